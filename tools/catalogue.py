"""Makes the catalogue's model files from a table of data-sheet figures.

    python tools/catalogue.py CATALOGUE.csv

reads the columns sensor, manufacturer, technology, quantity, axis_note, value, unit, condition, source and writes a file a
sensor to crates/sagnac-model/catalogue and the list of them to crates/sagnac-model/src/catalogue/embedded.rs. Which number
becomes which key is decided in `KEYS` and `mapped`; every number keeps its source, and its printed text as a note.
Needs nothing but Python.
"""

import csv
import math
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CRATE = ROOT / "crates" / "sagnac-model"
AXES = "xyz"
RANK = {"D": 0, "M": 1, "S": 2}

# quantity without the sensor -> (key, how): `plain` the figure is the value, `sigma` the value is zero and the figure its 1 sigma
KEYS = {
    "arw": ("noise.angle_random_walk", "plain"),
    "vrw": ("noise.velocity_random_walk", "plain"),
    "bias_repeatability": ("bias.stability", "plain"),
    "bias_random_walk": ("noise.acceleration_random_walk", "plain"),
    "bias_initial_tolerance": ("bias.fixed", "sigma"),
    "bias_tempco": ("bias.temperature", "sigma"),
    "scale_factor_error": ("scale_factor.stability", "plain"),
    "scale_factor_tolerance": ("scale_factor.fixed", "sigma"),
    "scale_factor_tempco": ("scale_factor.temperature", "sigma"),
    "cross_axis": ("cross_axis.fixed", "sigma"),
    "g_sensitivity": ("g_sensitivity.matrix", "sigma"),
    "range": ("range", "plain"),
    "bandwidth": ("bandwidth", "plain"),
    "resolution": ("resolution", "plain"),
    "sensitivity": ("resolution", "inverse"),
}
LISTED_BY = ("arw", "vrw", "noise_density", "bias_instability", "bias_repeatability")
WORDS = {
    "arw": "angle random walk", "vrw": "velocity random walk", "rms_noise": "rms noise", "vre": "vibration rectification",
}


def number(text):
    """The larger end of a printed number, range or pair."""
    parts = [part for part in re.split(r"\.\.|/|(?<=[0-9])-(?=[0-9])", text) if part]
    return max((float(part), part) for part in parts)


def usable(row):
    source = row["source"]
    return not source.startswith(("from memory", "none", "T:")) and row["value"] != "not found"


def unit_of(row):
    """The unit in the spelling of the model file, and a factor."""
    unit = row["unit"].replace(" rms", "").replace("dps", "deg/s")
    unit = unit.replace("mdeg/s", "mdps")
    unit = re.sub(r"/C\b", "/K", unit)
    unit = re.sub(r"/LSB$|/pulse$| per count$", "", unit)
    if unit == "um/s^2":
        return "mGal", 0.1
    if row["quantity"].endswith("cross_axis") and unit == "urad":
        return "ppm", 1.0
    return unit, 1.0


def decimal(value, printed, factor):
    """The printed digits where nothing is changed, else the shortest decimal of 12 digits."""
    if factor == 1.0:
        return printed
    return f"{value * factor:.12g}"


def mapped(row):
    """(sensor, key, how) of a row, or None where it is a note."""
    quantity = row["quantity"]
    if quantity == "output_rate_max":
        return (None, "sample_rate", "plain")
    sensor, _, name = quantity.partition("_")
    if sensor not in ("gyro", "accel") or "%FS" in row["unit"]:
        return None
    if name == "bias_instability":
        coefficient = "divided by 0.664" in row["condition"] or "Allan B" in row["condition"]
        return (sensor, "bias.instability." + ("coefficient" if coefficient else "allan_minimum"), "plain")
    if name == "misalignment":
        stability = "stability" in row["condition"]
        return (sensor, "misalignment." + ("stability" if stability else "fixed"), "plain" if stability else "sigma")
    if name == "bandwidth" and ".." in row["value"]:
        return None
    if name in KEYS:
        key, how = KEYS[name]
        return (sensor, key, how)
    return None


def named_range(row):
    """The full scale that a condition names, 0 where it names none."""
    found = re.findall(r"(\d+(?:\.\d+)?) ?(?:deg/s|dps|g)\b", row["condition"])
    return max(map(float, found), default=0.0)


def order(row):
    return (RANK[row["source"][0]], -named_range(row), "1 sigma" not in row["condition"])


def on_axis(row, axis):
    return row["axis_note"] == "" or axis in row["axis_note"].split(",")


def value_of(row, how):
    """The figure as a number of its unit, and its text."""
    value, printed = number(row["value"])
    unit, factor = unit_of(row)
    if "3 sigma" in row["condition"]:
        factor /= 3.0
    if how == "inverse":
        top = re.fullmatch(r"LSB/\(?(.*?)\)?", unit).group(1)
        return 1.0 / value, f"{1.0 / value:.12g}", top
    return value * factor, decimal(value, printed, factor), unit


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def printed(row):
    note = f"printed {row['value']} {row['unit']}".strip()
    if row["axis_note"]:
        note += f" on {row['axis_note']}"
    if row["condition"]:
        note += f"; {row['condition']}"
    return note


def cell(fields, row, note=None):
    parts = [f"{key} = {quoted(value)}" for key, value in fields]
    parts.append(f"source = {quoted(row['source'])}")
    parts.append(f"note = {quoted(printed(row) + (f'; {note}' if note else ''))}")
    return "{ " + ", ".join(parts) + " }"


def fields_of(row, how, density=None):
    _, text, unit = value_of(row, how)
    if how == "sigma":
        return [("value", f"0 {unit}"), ("sigma", f"{text} {unit}")]
    if density == "between":
        value, _, _ = value_of(row, how)
        return [("value", f"{text} {unit}"), ("lower", f"{value / math.sqrt(2):.12g} {unit}"), ("upper", f"{text} {unit}")]
    return [("value", f"{text} {unit}")]


def item(key, chosen, how, density=None):
    """The TOML of a key from the row chosen for each axis."""
    note = "between ND/sqrt(2) and ND: the sheet does not say whether the density is one- or two-sided" if density == "between" else None
    cells = [cell(fields_of(row, how, density), row, note) for row in chosen]
    if key == "g_sensitivity.matrix":
        unit = value_of(chosen[0], how)[2]
        zero = quoted(f"0 {unit}")
        rows = [[cells[i] if i == j else zero for j in range(3)] for i in range(3)]
        return "[\n" + "".join("    [" + ", ".join(line) + "],\n" for line in rows) + "]"
    text = cells[0] if len(set(cells)) == 1 else "[\n" + "".join(f"    {one},\n" for one in cells) + "]"
    if key.endswith(".temperature"):
        return f"[{text}]" if len(set(cells)) == 1 else f"[{text}]"
    return text


def choose(rows, how, largest=False):
    """The row for each axis, by the rules; an axis without a figure takes the largest of the others."""
    chosen = {}
    for axis in AXES:
        candidates = [row for row in rows if on_axis(row, axis)]
        if not candidates:
            continue
        if largest:
            chosen[axis] = max(candidates, key=lambda row: to_si(row, how))
        else:
            chosen[axis] = min(candidates, key=order)
    spare = max(chosen.values(), key=lambda row: to_si(row, how))
    return [chosen.get(axis, spare) for axis in AXES]


SI = {"deg/s": math.pi / 180, "g": 9.80665, "m/s^2": 1.0}


def to_si(row, how):
    value, _, unit = value_of(row, how)
    return value * SI.get(unit, 1.0)


def band(text):
    """The interval that the printed digits allow."""
    digits = len(text.split(".")[1]) if "." in text else 0
    half = 0.5 * 10.0**-digits
    return float(text) - half, float(text) + half


DENSITY_SI = {
    "deg/s/sqrt(Hz)": math.pi / 180, "mdps/sqrt(Hz)": math.pi / 180e3, "deg/h/sqrt(Hz)": math.pi / 180 / 3600,
    "ug/sqrt(Hz)": 9.80665e-6, "mg/sqrt(Hz)": 9.80665e-3, "deg/sqrt(h)": math.pi / 180 / 60, "rad/s/sqrt(Hz)": 1.0,
    "m/s/sqrt(h)": 1 / 60, "ft/s/sqrt(h)": 0.3048 / 60, "m/s^2/sqrt(Hz)": 1.0,
}


def density_note(sensor, row, white):
    name = "N"
    low_n, high_n = (v * DENSITY_SI[unit_of(white)[0]] for v in band(number(white["value"])[1]))
    low_d, high_d = (v * DENSITY_SI[unit_of(row)[0]] for v in band(number(row["value"])[1]))
    ratio = (low_n + high_n) / (low_d + high_d)
    low, high = low_n / high_d, high_n / low_d
    if low <= math.sqrt(0.5) <= high:
        says = "the density is one-sided"
    elif low <= 1.0 <= high:
        says = "the density is two-sided"
    else:
        says = "the two disagree"
    return f"{words(sensor, 'noise_density')} {figure(row)}: {name}/ND = {ratio:.3f}, {says} ({row['source']})"


def words(sensor, name):
    sensor = {"gyro": "gyro", "accel": "accelerometer"}.get(sensor, sensor)
    return f"{sensor} {WORDS.get(name, name.replace('_', ' '))}"


def figure(row):
    text = f"{row['value']} {row['unit']}"
    if row["axis_note"]:
        text += f" on {row['axis_note']}"
    return text + (f" ({row['condition']})" if row["condition"] else "")


PATHS = {"bias.fixed": "bias", "scale_factor.fixed": "scale_factor", "misalignment.fixed": "misalignment",
         "cross_axis.fixed": "cross_axis", "g_sensitivity.matrix": "g_sensitivity",
         "bias.temperature": "bias.temperature.1", "scale_factor.temperature": "scale_factor.temperature.1"}


def model(sensor, rows):
    """The text of a sensor's file, or None where it is not listed."""
    rows = [row for row in rows if usable(row)]
    if not any(row["quantity"].partition("_")[2] in LISTED_BY for row in rows):
        return None
    groups, notes, price = {}, [], None
    for row in rows:
        if row["quantity"] == "price":
            price = row
        target = mapped(row)
        name = row["quantity"].partition("_")[2]
        if name == "noise_density":
            continue
        if target is None:
            if row["quantity"] != "price":
                notes.append(f"{words(*row['quantity'].split('_', 1))} {figure(row)} ({row['source']})")
            continue
        # Instability has two keys and one number.
        group = (target[0], "bias.instability" if "instability" in target[1] else target[1])
        groups.setdefault(group, []).append((row, target[1], target[2]))
    used, lines, conflicts = [], {}, []
    for (kind, group), members in groups.items():
        hows = {id(row): how for row, _, how in members}
        keys = {id(row): key for row, key, _ in members}
        candidates = [row for row, _, _ in members]
        chosen = choose_group(candidates, hows, group)
        key, how = keys[id(chosen[0])], hows[id(chosen[0])]
        chosen = [row if keys[id(row)] == key else chosen[0] for row in chosen]
        lines[(kind, key)] = (item(key, chosen, how), chosen, how)
        used += [row for row in chosen if row not in used]
        path = ".".join(part for part in (kind, PATHS.get(key, key)) if part)
        conflict(conflicts, notes, path, chosen, how, candidates)
    densities(rows, lines, used, conflicts, notes)
    quality = max((row["source"][0] for row in used), key=lambda letter: RANK[letter])
    return text_of(sensor, rows[0], lines, quality, price, notes, conflicts)


def choose_group(candidates, hows, group):
    if group == "range":
        return choose(candidates, "plain", largest=True)
    chosen = {}
    for axis in AXES:
        mine = [row for row in candidates if on_axis(row, axis)]
        if mine:
            chosen[axis] = min(mine, key=order)
    spare = max(chosen.values(), key=lambda row: value_of(row, hows[id(row)])[0])
    return [chosen.get(axis, spare) for axis in AXES]


def conflict(conflicts, notes, path, chosen, how, candidates):
    same = lambda row: any((row["value"], row["unit"]) == (one["value"], one["unit"]) for one in chosen)
    others = [row for row in candidates if row not in chosen and not same(row)]
    for row in candidates:
        if row not in chosen and same(row):
            notes.append(f"{path}: {figure(row)} is also printed by {row['source']}")
    if others:
        _, text, unit = value_of(chosen[0], how)
        conflicts.append((path, f"{text} {unit}", others))


def densities(rows, lines, used, conflicts, notes):
    for sensor, key in (("gyro", "noise.angle_random_walk"), ("accel", "noise.velocity_random_walk")):
        found = [row for row in rows if row["quantity"] == f"{sensor}_noise_density"]
        if not found:
            continue
        if (sensor, key) in lines:
            white = lines[(sensor, key)][1][0]
            notes += [density_note(sensor, row, white) for row in found]
            continue
        chosen = choose_group(found, {id(row): "plain" for row in found}, "")
        one_sided = ["one-sided" in row["condition"] for row in chosen]
        if all(one_sided):
            key = "noise.noise_density_one_sided"
            lines[(sensor, key)] = (item(key, chosen, "plain"), chosen, "plain")
        else:
            lines[(sensor, key)] = (item(key, chosen, "plain", "between"), chosen, "plain")
        used += [row for row in chosen if row not in used]
        conflict(conflicts, notes, f"{sensor}.{key}", chosen, "plain", found)


ORDER = ["range", "resolution", "bandwidth", "bias.fixed", "bias.temperature", "bias.stability",
         "bias.instability.coefficient", "bias.instability.allan_minimum", "scale_factor.fixed",
         "scale_factor.temperature", "scale_factor.stability", "misalignment.fixed", "misalignment.stability",
         "cross_axis.fixed", "g_sensitivity.matrix", "noise.angle_random_walk", "noise.velocity_random_walk",
         "noise.noise_density_one_sided", "noise.acceleration_random_walk"]

CLASSES = [(10, "<10"), (100, "10-100"), (1000, "100-1000"), (10000, "1000-10000"), (100000, "10000-100000")]


def price_class(row):
    usd = number(row["value"])[0] * (1.1 if row["unit"] == "EUR" else 1.0)
    return next((name for top, name in CLASSES if usd < top), ">100000")


def text_of(sensor, row, lines, quality, price, notes, conflicts):
    out = ["schema = 1", f"name = {quoted(sensor)}"]
    if row["manufacturer"]:
        out.append(f"manufacturer = {quoted(row['manufacturer'])}")
    if (None, "sample_rate") in lines:
        out.append(f"sample_rate = {lines[(None, 'sample_rate')][0]}")
    kinds = [kind for kind in ("gyro", "accel") if any(k == kind for k, _ in lines)]
    for kind in kinds:
        out += ["", f"[{kind}]"]
        if kind == kinds[0] or row["technology"].startswith("MEMS"):
            out.append(f"technology = {quoted(row['technology'])}")
        table = ""
        for key in ORDER:
            if (kind, key) not in lines:
                continue
            text, chosen, _ = lines[(kind, key)]
            where, _, last = key.rpartition(".")
            if where != table:
                out += ["", f"[{kind}.{where}]"]
                table = where
            if key == "resolution" and re.search(r"/pulse| per count", chosen[0]["unit"]):
                out.append('output = "increment"')
            out.append(f"{last} = {text}")
    out += ["", "[catalog]", f"quality = {quoted(quality)}"]
    if price:
        condition = f", {price['condition']}" if price["condition"] else ""
        evidence = f"{price['value']} {price['unit']}{condition}: {price['source']}"
        out += [f"price_class = {quoted(price_class(price))}", f"price_evidence = {quoted(evidence)}"]
    if notes:
        out += ["notes = [", *(f"    {quoted(note)}," for note in notes), "]"]
    for path, text, others in conflicts:
        out += ["", "[[catalog.conflicts]]", f"parameter = {quoted(path)}", f"used = {quoted(text)}", "others = ["]
        for other in others:
            out.append(f"    {{ value = {quoted(other['value'])}, unit = {quoted(other['unit'])}, source = {quoted(other['source'])} }},")
        out.append("]")
    return "\n".join(out) + "\n"


def slug(name):
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-")


def main():
    with open(sys.argv[1], newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    folder = CRATE / "catalogue"
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.toml"):
        old.unlink()
    sensors = {}
    for row in rows:
        sensors.setdefault(row["sensor"], []).append(row)
    names = []
    for sensor, mine in sensors.items():
        text = model(sensor, mine)
        if text is not None:
            (folder / f"{slug(sensor)}.toml").write_text(text, encoding="utf-8")
            names.append(sensor)
    names.sort(key=slug)
    embedded = CRATE / "src" / "catalogue" / "embedded.rs"
    embedded.parent.mkdir(exist_ok=True)
    body = "".join(f'    ({quoted(name)}, include_str!("../../catalogue/{slug(name)}.toml")),\n' for name in names)
    embedded.write_text(
        "//! The catalogue's files by name. Made by `tools/catalogue.py`; do not edit.\n\n"
        f"/// Name as printed, and the text of the model file.\npub(super) const FILES: [(&str, &str); {len(names)}] = [\n{body}];\n",
        encoding="utf-8",
    )
    print(f"{len(names)} of {len(sensors)} sensors")


main()
