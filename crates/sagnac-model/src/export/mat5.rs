//! MAT-file level 5: one struct of row vectors of doubles [MATLAB MAT-File Format].

/// The file with a 1×1 struct whose fields are 1×n doubles.
pub(crate) fn write(name: &str, fields: &[(&str, Vec<f64>)]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut text = b"MATLAB 5.0 MAT-file, written by sagnac".to_vec();
    text.resize(116, b' ');
    file.extend(text);
    file.extend([0; 8]);
    file.extend(0x0100_u16.to_le_bytes());
    file.extend(b"IM");
    let mut body = Vec::new();
    element(&mut body, 6, &flags(2));
    element(&mut body, 5, &dimensions(1, 1));
    element(&mut body, 1, name.as_bytes());
    let length = 32_usize;
    // The length of a field name is a small element.
    body.extend(5_u16.to_le_bytes());
    body.extend(4_u16.to_le_bytes());
    body.extend((length as u32).to_le_bytes());
    let mut names = Vec::new();
    for (field, _) in fields {
        let mut padded = field.as_bytes().to_vec();
        padded.truncate(length - 1);
        padded.resize(length, 0);
        names.extend(padded);
    }
    element(&mut body, 1, &names);
    for (_, values) in fields {
        let mut inner = Vec::new();
        element(&mut inner, 6, &flags(6));
        element(&mut inner, 5, &dimensions(1, values.len()));
        element(&mut inner, 1, b"");
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        element(&mut inner, 9, &bytes);
        element(&mut body, 14, &inner);
    }
    element(&mut file, 14, &body);
    file
}

fn flags(class: u32) -> Vec<u8> {
    [class.to_le_bytes(), 0_u32.to_le_bytes()].concat()
}

fn dimensions(rows: usize, columns: usize) -> Vec<u8> {
    [(rows as u32).to_le_bytes(), (columns as u32).to_le_bytes()].concat()
}

fn element(out: &mut Vec<u8>, kind: u32, data: &[u8]) {
    out.extend(kind.to_le_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
}

/// One element: kind, data, what follows.
fn next(bytes: &[u8]) -> Option<(u32, &[u8], &[u8])> {
    let word = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
    let head = word(0)?;
    if head >> 16 != 0 {
        let length = (head >> 16) as usize;
        return Some((
            head & 0xffff,
            bytes.get(4..4 + length.min(4))?,
            bytes.get(8..)?,
        ));
    }
    let length = word(4)? as usize;
    let data = bytes.get(8..8_usize.checked_add(length)?)?;
    let end = if head == 15 {
        8 + length
    } else {
        8 + length.next_multiple_of(8)
    };
    Some((head, data, bytes.get(end..).unwrap_or(&[])))
}

/// The doubles of the fields of the first struct, uncompressed little-endian files only; none where it is no such file.
pub(crate) fn read(bytes: &[u8]) -> Option<Vec<(String, Vec<f64>)>> {
    if bytes.get(124..128)? != [0, 1, b'I', b'M'] {
        return None;
    }
    let mut rest = bytes.get(128..)?;
    while let Some((kind, data, after)) = next(rest) {
        if kind == 14
            && let Some(fields) = structure(data)
        {
            return Some(fields);
        }
        rest = after;
    }
    None
}

fn structure(data: &[u8]) -> Option<Vec<(String, Vec<f64>)>> {
    let (_, flags, rest) = next(data)?;
    if flags.first() != Some(&2) {
        return None;
    }
    let (_, _, rest) = next(rest)?;
    let (_, _, rest) = next(rest)?;
    let (_, length, rest) = next(rest)?;
    let length = u32::from_le_bytes(length.get(..4)?.try_into().ok()?) as usize;
    let (_, names, mut rest) = next(rest)?;
    if !(1..=64).contains(&length) {
        return None;
    }
    let mut fields = Vec::new();
    for name in names.chunks(length) {
        let name: String = name
            .iter()
            .take_while(|byte| **byte != 0)
            .map(|byte| char::from(*byte))
            .collect();
        let (kind, matrix, after) = next(rest)?;
        rest = after;
        if kind == 14
            && let Some(values) = doubles(matrix)
        {
            fields.push((name, values));
        }
    }
    Some(fields)
}

fn doubles(data: &[u8]) -> Option<Vec<f64>> {
    let (_, flags, rest) = next(data)?;
    if flags.first() != Some(&6) {
        return None;
    }
    let (_, _, rest) = next(rest)?;
    let (_, _, rest) = next(rest)?;
    let (kind, values, _) = next(rest)?;
    // MATLAB stores small integers in fewer bytes.
    Some(match kind {
        9 => values
            .chunks_exact(8)
            .map(|chunk| f64::from_le_bytes(chunk.try_into().unwrap_or_default()))
            .collect(),
        1 => values.iter().map(|byte| f64::from(*byte as i8)).collect(),
        2 => values.iter().map(|byte| f64::from(*byte)).collect(),
        3 => values
            .chunks_exact(2)
            .map(|chunk| f64::from(i16::from_le_bytes(chunk.try_into().unwrap_or_default())))
            .collect(),
        4 => values
            .chunks_exact(2)
            .map(|chunk| f64::from(u16::from_le_bytes(chunk.try_into().unwrap_or_default())))
            .collect(),
        5 => values
            .chunks_exact(4)
            .map(|chunk| f64::from(i32::from_le_bytes(chunk.try_into().unwrap_or_default())))
            .collect(),
        _ => return None,
    })
}
