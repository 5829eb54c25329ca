//! What the failures of a run have in common: mistakes that several cases show, and words that only failing cases carry.

use crate::conformance::{Outcome, Verdict};

/// A mistake and the cases that look like it.
#[derive(Debug, PartialEq)]
pub(super) struct Suspect {
    pub says: String,
    pub cases: Vec<String>,
}

/// A property and how its cases fare.
#[derive(Debug, PartialEq)]
pub(super) struct Property {
    pub name: String,
    pub wrong: usize,
    pub all: usize,
}

/// Mistakes that failing cases look like, most cases first.
pub(super) fn suspects(outcomes: &[Outcome]) -> Vec<Suspect> {
    let mut suspects: Vec<Suspect> = Vec::new();
    for outcome in outcomes {
        for says in outcome.findings.iter().flat_map(|f| &f.diagnoses).map(|d| &d.says) {
            let name = &outcome.case.name;
            match suspects.iter_mut().find(|s| s.says == *says) {
                Some(suspect) if suspect.cases.contains(name) => {}
                Some(suspect) => suspect.cases.push(name.clone()),
                None => suspects.push(Suspect { says: says.clone(), cases: vec![name.clone()] }),
            }
        }
    }
    suspects.sort_by_key(|s| std::cmp::Reverse(s.cases.len()));
    suspects
}

/// Properties with how many of their cases did not pass; first those that tell failures from passes best, by the
/// correlation φ of "has the property" with "fails". A property that many cases have counts for more than one of a
/// single case.
pub(super) fn properties(outcomes: &[Outcome]) -> Vec<Property> {
    let mut properties: Vec<Property> = Vec::new();
    for outcome in outcomes {
        let wrong = usize::from(outcome.verdict > Verdict::Inconclusive);
        for name in &outcome.case.tests {
            match properties.iter_mut().find(|p| p.name == *name) {
                Some(property) => {
                    property.wrong += wrong;
                    property.all += 1;
                }
                None => properties.push(Property { name: name.clone(), wrong, all: 1 }),
            }
        }
    }
    let failed = outcomes.iter().filter(|outcome| outcome.verdict > Verdict::Inconclusive).count();
    let tells = |p: &Property| correlation([p.wrong, p.all], [failed, outcomes.len()]);
    properties.sort_by(|a, b| tells(b).total_cmp(&tells(a)).then(b.wrong.cmp(&a.wrong)));
    properties
}

/// φ of "has the property" with "fails", from −1 to 1: how many fail and how many there are, with the property and in
/// all. 0 where all cases or none have the property or fail, since then it tells nothing.
fn correlation([wrong, all]: [usize; 2], [failed, total]: [usize; 2]) -> f64 {
    let [wrong, all, failed, total] = [wrong, all, failed, total].map(|n| n as f64);
    let spread = all * (total - all) * failed * (total - failed);
    if spread > 0.0 { (wrong * total - all * failed) / spread.sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_tells_failures_from_passes_comes_first() {
        let all = [10, 20];
        assert_eq!(correlation([10, 10], all), 1.0);
        assert_eq!(correlation([0, 10], all), -1.0);
        assert_eq!(correlation([5, 10], all), 0.0);
        assert!(
            correlation([9, 10], all) > correlation([1, 1], all),
            "many of many tell more than one of one"
        );
        assert_eq!(correlation([10, 20], all), 0.0);
        assert_eq!(correlation([3, 3], [20, 20]), 0.0);
    }
}
