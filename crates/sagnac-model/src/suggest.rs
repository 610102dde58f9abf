//! The nearest of some names: for `did you mean`.
//!
//! Distance: optimal string alignment (insertions, deletions, substitutions, swaps of neighbors).

/// The name nearest to `wanted`, if it is near enough to be a slip of the pen.
///
/// ```
/// assert_eq!(sagnac_model::suggest("angel_random_walk", ["angle_random_walk", "quantization"]), Some("angle_random_walk"));
/// assert_eq!(sagnac_model::suggest("zzz", ["angle_random_walk"]), None);
/// ```
pub fn suggest<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Longer input is no slip of the pen, and the distance is quadratic in the length.
    if wanted.len() > 80 {
        return None;
    }
    let folded = wanted.to_lowercase();
    let mut best: Option<(usize, &str)> = None;
    for name in names {
        let distance = distance(&folded, &name.to_lowercase());
        if best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, name));
        }
    }
    let (distance, name) = best?;
    (distance <= (name.chars().count().max(folded.chars().count()) / 3).max(1)).then_some(name)
}

fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.chars().collect();
    let b: Vec<char> = b.chars().take(120).collect();
    let mut two_ago = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let change = usize::from(a[i - 1] != b[j - 1]);
            row[j] = (last[j] + 1).min(row[j - 1] + 1).min(last[j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(two_ago[j - 2] + 1);
            }
        }
        two_ago = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::distance;

    #[test]
    fn a_swap_counts_one() {
        assert_eq!(distance("angel", "angle"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
    }
}
