//! The verdict in plain words, with numbers rounded to their uncertainty: one wording for the
//! command line, the report, the live page and the terminal dashboard.

use crate::estimate::Estimate;
use crate::judgement::Judgement;

/// The verdict on the estimate of any machine.
pub fn verdict<E: Estimate>(estimate: &E) -> String {
    let sentences: Vec<_> = estimate
        .judgements()
        .iter()
        .map(Judgement::sentence)
        .collect();
    sentences.join(" ")
}

/// Remedy for the reason `code`, by the names of all reasons.
pub(crate) fn remedy(
    code: u32,
    reasons: &[(&str, &str)],
    remedies: &[(&str, &'static str)],
) -> Option<&'static str> {
    let (name, _) = reasons.get(code as usize)?;
    let row = remedies.iter().find(|(reason, _)| reason == name)?;
    Some(row.1)
}

/// A headline quantity over a whole run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunJudgement {
    /// The last trusted estimate, else the last one.
    pub reported: Judgement,
    /// Time of it \[s\].
    pub time: f64,
    /// Judgement at the end, if it is not `reported`.
    pub end: Option<Judgement>,
    /// Share of the samples that were trusted.
    pub trusted_share: f64,
    /// Index of the estimate of `reported`.
    pub index: usize,
}

/// Judgement of a whole run on each headline quantity: a machine that stands still at the end has not lost its earlier estimate.
/// Empty without an estimate.
pub fn run_judgements<E: Estimate>(estimates: &[E]) -> Vec<RunJudgement> {
    let Some(last) = estimates.last() else {
        return Vec::new();
    };
    let over_the_run = |(i, bit): (usize, u32)| {
        let trusted = |e: &&E| e.flags() & bit != 0;
        let index = estimates.iter().rposition(|e| trusted(&e));
        let at = index.unwrap_or(estimates.len() - 1);
        let end = (at + 1 != estimates.len()).then(|| last.judgements().swap_remove(i));
        RunJudgement {
            reported: estimates[at].judgements().swap_remove(i),
            time: estimates[at].stamp().time,
            end: end.filter(|e| !e.trusted),
            trusted_share: estimates.iter().filter(trusted).count() as f64 / estimates.len() as f64,
            index: at,
        }
    };
    E::headlines()
        .map(|p| p.trusted)
        .enumerate()
        .map(over_the_run)
        .collect()
}

/// A text in lines of at most `width` characters, broken between words; a longer word has a line of
/// its own.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let length = |line: &str| line.chars().count();
        match lines.last_mut() {
            Some(line) if length(line) + 1 + length(word) <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::GROUP;
    use messages::{ExcavatorEstimate, LoaderEstimate, excavator_bits as x, loader_bits as l};

    fn plain(text: &str) -> String {
        text.replace(GROUP, " ")
    }

    fn inertia(flags: u32) -> ExcavatorEstimate {
        ExcavatorEstimate {
            inertia: 5873.2,
            inertia_std: 61.2,
            estimated: x::INERTIA,
            flags,
            ..Default::default()
        }
    }

    const ALL: u32 = x::EXCITED | x::CONSISTENT | x::FRESH | x::CONVERGED | x::IDENTIFIABLE;

    #[test]
    fn a_trusted_inertia_says_value_interval_and_why() {
        let text = plain(&verdict(&inertia(ALL | x::TRUSTED)));
        assert!(text.starts_with("The swing inertia is 5 873 ± 61 kg m² (95 %: 5 753 to 5 993 kg m²). heft trusts it:"), "{text}");
    }

    #[test]
    fn a_machine_that_stands_is_not_said_to_swing() {
        let swings = verdict(&inertia(ALL | x::TRUSTED));
        let stands = verdict(&inertia(ALL | x::TRUSTED | x::HELD));
        assert!(swings.contains("the machine swings"), "{swings}");
        assert!(
            stands.contains("the machine stands still, and its pressures weigh"),
            "{stands}"
        );
        assert!(!stands.contains("swings"), "{stands}");
    }

    #[test]
    fn every_missing_bit_is_a_reason_of_its_own() {
        for bit in [
            x::EXCITED,
            x::CONSISTENT,
            x::FRESH,
            x::CONVERGED,
            x::IDENTIFIABLE,
        ] {
            let judgement = inertia(ALL & !bit).judgements().swap_remove(0);
            assert!(!judgement.trusted);
            assert_eq!(judgement.reasons.len(), 1, "{judgement:?}");
        }
        let none = inertia(0).judgements().swap_remove(0);
        let distinct: std::collections::HashSet<_> = none.reasons.iter().collect();
        // Where measurements are missing, a slow swing is no reason beside that.
        assert_eq!(distinct.len(), 4);
    }

    /// The rows of a table in docs/reasons.md are these reasons, each with its remedy.
    fn is_documented(heading: &str, reasons: &[(&str, &str)], remedies: &[(&str, &str)]) {
        let page = include_str!("../../../docs/reasons.md");
        let (_, table) = page.split_once(heading).expect("a heading");
        let table = table.split("\n## ").next().expect("a section");
        for (name, _) in reasons.iter().skip(1) {
            let remedy = remedies.iter().find(|r| r.0 == *name);
            let (_, remedy) = remedy.unwrap_or_else(|| panic!("{name}: what to do?"));
            let row = table
                .lines()
                .find(|l| l.starts_with(&format!("| `{name}` |")));
            let row = row.unwrap_or_else(|| panic!("docs/reasons.md has no row of {name}"));
            let said = row.replace('`', "");
            assert!(said.contains(remedy), "{name}: {remedy}\n{row}");
        }
        assert_eq!(
            reasons.len() - 1,
            remedies.len(),
            "no remedy without a reason"
        );
    }

    #[test]
    fn page_and_programs_say_the_same_to_do_about_each_reason() {
        use crate::{excavator, loader};
        let (of_excavator, of_loader) = (messages::EXCAVATOR_REASONS, messages::LOADER_REASONS);
        is_documented(
            "## Reasons of the excavator",
            of_excavator,
            excavator::REMEDIES,
        );
        is_documented(
            "## Reasons of the wheel loader",
            of_loader,
            loader::REMEDIES,
        );
    }

    #[test]
    fn what_is_not_trusted_says_what_to_do() {
        let still = verdict(&inertia(ALL & !x::EXCITED | x::HELD));
        assert!(still.contains("What to do: swing"), "{still}");
        assert!(!verdict(&inertia(ALL | x::TRUSTED)).contains("What to do"));
    }

    /// Every reason and every flag that withholds trust has a remedy.
    #[test]
    fn every_reason_and_every_missing_flag_has_something_to_do() {
        let of_excavator = 0..messages::EXCAVATOR_REASONS.len() as u32;
        let of_loader = 0..messages::LOADER_REASONS.len() as u32;
        for flags in (0..8).map(|bit| 0xff & !(1 << bit)).chain([0, 0xff]) {
            for reason in of_excavator.clone() {
                let e = ExcavatorEstimate {
                    reason,
                    ..inertia(flags & !x::TRUSTED)
                };
                assert!(!e.judgements()[0].advice.is_empty(), "{reason}, {flags}");
            }
            for reason in of_loader.clone() {
                let e = LoaderEstimate {
                    reason,
                    flags,
                    estimated: l::STATE,
                    ..Default::default()
                };
                let judgements = e.judgements();
                assert!(
                    judgements.iter().all(|j| !j.advice.is_empty()),
                    "{reason}, {flags}"
                );
            }
        }
    }

    #[test]
    fn where_the_load_is_in_doubt_no_drive_without_digging_is_advised() {
        let advice = |reason: &str, estimated: u32| {
            let code = messages::LOADER_REASONS.iter().position(|r| r.0 == reason);
            let e = LoaderEstimate {
                reason: code.expect("a reason") as u32,
                flags: l::FRESH | l::CONSISTENT | l::FROZEN,
                estimated: l::STATE | estimated,
                ..Default::default()
            };
            e.judgements().swap_remove(0).advice
        };
        for (reason, estimated, words) in [
            ("load", l::PAYLOAD, "lift the bucket off the ground"),
            ("load", 0, "accelerate and brake with the new load"),
            ("lift cylinder", l::PAYLOAD, "check its pressures"),
            ("one way", 0, "without digging"),
        ] {
            let advice = advice(reason, estimated);
            assert!(advice.contains(words), "{reason}: {advice}");
        }
    }

    #[test]
    fn standstill_and_a_changing_payload_are_named() {
        let held = verdict(&inertia(ALL & !x::EXCITED | x::HELD));
        assert!(held.contains("stands still"), "{held}");
        let changing = verdict(&inertia(ALL & !x::CONVERGED | x::CHANGING));
        assert!(changing.contains("payload is changing"), "{changing}");
    }

    #[test]
    fn a_load_that_changes_is_named_once_beside_any_reason() {
        let of_loader = 0..messages::LOADER_REASONS.len() as u32;
        for reason in of_loader {
            let said = |changing: u32| {
                let e = LoaderEstimate {
                    reason,
                    flags: l::FRESH | l::CONSISTENT | changing,
                    estimated: l::STATE,
                    ..Default::default()
                };
                let reasons = e.judgements().swap_remove(0).reasons;
                let names = |words: &&String| words.contains("load may have changed");
                reasons.iter().filter(names).count()
            };
            let is_load = usize::from(messages::LOADER_REASONS[reason as usize].0 == "load");
            assert_eq!([said(0), said(l::CHANGING)], [is_load, 1], "{reason}");
        }
    }

    #[test]
    fn no_estimate_is_not_an_inertia_of_zero() {
        let text = verdict(&ExcavatorEstimate::default());
        assert!(text.starts_with("There is no swing inertia yet"), "{text}");
    }

    #[test]
    fn position_and_height_have_verdicts_of_their_own() {
        let estimate = LoaderEstimate {
            cg_ratio: 0.42,
            cg_ratio_std: 0.0042,
            cg_distance: 1.624,
            cg_height: 0.91,
            cg_height_std: 0.12,
            estimated: l::STATE,
            flags: l::EXCITED_RATIO
                | l::CONSISTENT
                | l::FRESH
                | l::CONVERGED_RATIO
                | l::TRUSTED_RATIO,
            ..Default::default()
        };
        let text = plain(&verdict(&estimate));
        assert!(
            text.contains("1.624 ± 0.012 m behind the front axle"),
            "{text}"
        );
        assert!(text.contains("heft trusts it"), "{text}");
        assert!(text.contains("0.91 ± 0.12 m above the ground"), "{text}");
        assert!(text.contains("heft does not trust it, because"), "{text}");
    }

    #[test]
    fn no_centre_of_gravity_lies_beyond_an_axle() {
        for cg_ratio in [1.0, 1.03, -0.02] {
            let estimate = LoaderEstimate {
                cg_ratio,
                cg_ratio_std: 0.04,
                cg_distance: 2.8 * (1.0 - cg_ratio),
                estimated: l::STATE,
                ..Default::default()
            };
            let text = plain(&verdict(&estimate));
            let words = format!("would carry {:.0}", 100.0 * cg_ratio).replace('-', "−");
            assert!(text.contains(&words) && !text.contains("behind"), "{text}");
        }
    }

    #[test]
    fn a_run_that_ends_at_standstill_shows_what_it_estimated_before() {
        let run = [
            inertia(0),
            inertia(ALL | x::TRUSTED),
            inertia(ALL & !x::EXCITED | x::HELD),
        ];
        let judgement = run_judgements(&run).swap_remove(0);
        assert!(judgement.reported.trusted && judgement.index == 1);
        assert!(
            judgement
                .end
                .is_some_and(|e| e.reasons[0].contains("stands still"))
        );
        assert!((judgement.trusted_share - 1.0 / 3.0).abs() < 1e-12);
        assert!(run_judgements::<ExcavatorEstimate>(&[]).is_empty());
    }
}
