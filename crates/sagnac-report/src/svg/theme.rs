//! Colors and classes of every drawing, from the tokens of the design.

/// Colors, sizes and type of every page and plot: custom properties for light, dark and print.
pub const TOKENS: &str = include_str!("../../assets/tokens.css");

/// Classes used inside drawings; the same text serves pages, stand-alone drawings and pictures.
///
/// `t` tick, `u` unit, `l` label, `g` grid, `a` axis, `m` measured, `f` fitted sum, `d` a term alone,
/// `q` an upper limit, `b` band, `c` curve in the current color, `k` leader.
pub const PLOT_CSS: &str = "\
svg text{font-family:var(--font);fill:var(--ink);font-variant-numeric:tabular-nums}\
svg .t,svg .u{fill:var(--muted)}\
svg .hd{font-size:16px;font-weight:600}\
svg .cap{font-size:12.5px;font-weight:600}\
svg .l{font-weight:600}\
svg .h{paint-order:stroke;stroke:var(--page);stroke-width:3.5px;stroke-linejoin:round}\
svg .lm{fill:var(--data)}svg .lf{fill:var(--fit)}svg .lc{fill:currentColor}svg .ln{fill:var(--muted)}\
svg .g{stroke:var(--grid);fill:none}svg .a{stroke:var(--muted);fill:none;stroke-width:1.2}\
svg .k{stroke:var(--muted);stroke-width:.8;fill:none}\
svg .b{fill:var(--band);stroke:none}svg .e{fill:var(--envelope);stroke:none}\
svg .m{fill:none;stroke:var(--data);stroke-width:1.8;stroke-linejoin:round}\
svg .s{fill:none;stroke:var(--data);stroke-width:1.1;stroke-linejoin:round}\
svg .f{fill:none;stroke:var(--fit);stroke-width:1.6;stroke-linejoin:round}\
svg .d{fill:none;stroke:var(--ink);stroke-width:1.2;stroke-dasharray:1.6 2.6}\
svg .q{fill:none;stroke:var(--muted);stroke-width:1.2;stroke-dasharray:5 3.5}\
svg .c{fill:none;stroke:currentColor;stroke-width:1.8;stroke-linejoin:round}\
svg .bc{fill:currentColor;fill-opacity:.16;stroke:none}\
svg .p{fill:currentColor;fill-opacity:.8;stroke:none}\
svg .o{fill:var(--page);stroke:var(--ink);stroke-width:1.6}\
svg .w{fill:var(--warn-fill);fill-opacity:.75;stroke:none}\
";

/// Names and light values of the colors of the tokens.
///
/// A test keeps them equal to [`TOKENS`].
pub const fn light_palette() -> &'static [(&'static str, &'static str)] {
    &[
        ("--page", "#fcfcfa"),
        ("--card", "#ffffff"),
        ("--ink", "#1b1f24"),
        ("--muted", "#59616b"),
        ("--rule", "#d8dce1"),
        ("--grid", "#e6e8eb"),
        ("--x", "#0b62a4"),
        ("--y", "#ac4308"),
        ("--z", "#0a7052"),
        ("--w", "#3b4047"),
        ("--data", "#0b62a4"),
        ("--fit", "#ac4308"),
        ("--band", "#0b62a42e"),
        ("--envelope", "#0b62a440"),
        ("--good", "#0a7052"),
        ("--warn", "#8a5a00"),
        ("--bad", "#b3261e"),
        ("--warn-fill", "#f6e3b4"),
        ("--bad-fill", "#f7cfcb"),
        ("--soft", "#f1f3f4"),
    ]
}

/// Replaces every `var(--name)` by its light value.
pub(super) fn resolve_light(text: &str) -> String {
    let mut out = text.replace("var(--font)", "Inter");
    for (name, value) in light_palette() {
        out = out.replace(&format!("var({name})"), value);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_palette_is_that_of_the_tokens() {
        let light = TOKENS.split("@media").next().unwrap_or_default();
        for (name, value) in light_palette() {
            assert!(
                light.contains(&format!("{name}: {value};")),
                "{name}: {value}"
            );
        }
    }
}
