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

/// Properties with the share of their cases that did not pass, worst first.
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
    let share = |p: &Property| p.wrong as f64 / p.all as f64;
    properties.sort_by(|a, b| share(b).total_cmp(&share(a)).then(b.wrong.cmp(&a.wrong)));
    properties
}
