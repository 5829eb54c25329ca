//! Wrong names are answered with the right ones, nearest first.

/// “there is no KIND WANTED; did you mean …? known: …”, nearest names first.
pub(super) fn unknown<'a>(kind: &str, wanted: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    const MOST_SHOWN: usize = 12;
    let sorted = nearest_first(wanted, known);
    let shown: Vec<&str> = sorted.iter().take(MOST_SHOWN).map(|&(_, name)| name).collect();
    let rest = sorted.len() - shown.len();
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    match sorted.first() {
        None => format!("there is no {kind} {wanted:?}, and none at all"),
        Some(&(distance, name)) if is_near(distance, wanted) => {
            format!("there is no {kind} {wanted:?}; did you mean {name}? known: {}{more}", shown.join(", "))
        }
        Some(_) => format!("there is no {kind} {wanted:?}; known: {}{more}", shown.join(", ")),
    }
}

fn nearest_first<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<(usize, &'a str)> {
    let wanted = wanted.to_lowercase();
    let mut sorted: Vec<_> =
        known.into_iter().map(|name| (distance(&wanted, &name.to_lowercase()), name)).collect();
    sorted.sort_by_key(|&(distance, _)| distance);
    sorted
}

/// Whether a distance is small enough to suggest a slip of the finger.
fn is_near(distance: usize, wanted: &str) -> bool {
    distance <= 1 + wanted.chars().count() / 4
}

/// Edit distance (insertions, deletions, substitutions, swaps of neighbours), or 1 where one is the beginning of the
/// other.
fn distance(a: &str, b: &str) -> usize {
    if !a.is_empty() && !b.is_empty() && a != b && (b.starts_with(a) || a.starts_with(b)) {
        return 1;
    }
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before_last = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let substituted = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substituted.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before_last[j - 2] + 1);
            }
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_count_slips() {
        for (a, b, d) in
            [("", "", 0), ("abc", "abc", 0), ("", "abc", 3), ("kitten", "sitting", 3), ("agx", "axg", 1)]
        {
            assert_eq!(distance(a, b), d, "{a} {b}");
            assert_eq!(distance(b, a), d, "{b} {a}");
        }
        assert_eq!(distance("random", "random-walk"), 1);
    }

    #[test]
    fn the_nearest_name_comes_first() {
        let text = unknown("tone map", "Linaer", ["pbr-neutral", "aces", "agx", "linear"]);
        assert!(text.contains("did you mean linear? known: linear, "), "{text}");
        let text = unknown("camera", "zzzzzz", ["a", "b"]);
        assert!(!text.contains("did you mean") && text.contains("known: a, b"), "{text}");
        assert!(unknown("camera", "x", []).contains("none at all"));
    }
}
