//! Names of scenarios and of working machines on the command line.

/// The scenarios of a machine, a row each: variant, name, one line of explanation.
macro_rules! scenarios {
    ($(#[$what:meta])* $( $variant:ident $name:literal $text:literal; )*) => {
        $(#[$what])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Scenario { $( #[doc = $text] $variant, )* }

        impl Scenario {
            /// Name and description of every scenario.
            pub const ALL: &[(&str, &str)] = &[$( ($name, $text) ),*];

            /// All scenarios, in the order of [`Self::ALL`].
            pub fn all() -> impl Iterator<Item = Self> {
                [$( Self::$variant ),*].into_iter()
            }

            /// The name that [`Self::parse`] reads.
            pub fn name(self) -> &'static str {
                Self::ALL[self as usize].0
            }
        }
    };
}
pub(crate) use scenarios;

/// The name of the scenario of an effect: `work-slope-4-deg`, `work-torque-gain-minus-5`, `work` for none.
pub fn scenario(effect: &str, severity: &str) -> String {
    let text = if effect == "none" {
        String::new()
    } else {
        format!("{effect} {severity}")
    };
    let text = text.to_lowercase().replace('+', "plus ");
    let mut name = String::from("work");
    for (i, word) in text.split([' ', ',']).enumerate() {
        // A minus before a number becomes a word; a point before a digit belongs to it.
        let word = if i > 0 {
            word.replace('-', "minus-")
        } else {
            word.into()
        };
        let word: String = word
            .chars()
            .filter(|c| c.is_alphanumeric() || *c == '-' || *c == '.')
            .collect();
        if !word.is_empty() {
            name.push('-');
            name.push_str(&word);
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_machine_at_work_has_a_name_of_its_own() {
        let excavators = crate::excavator::cases()
            .into_iter()
            .map(|c| scenario(c.0, c.1));
        let loaders = crate::loader::CASES.map(|c| scenario(c.0, c.1));
        let (mut excavators, mut loaders) = (excavators.collect::<Vec<_>>(), loaders.to_vec());
        assert!(
            excavators.contains(&"work-torque-gain-minus-5".to_owned()),
            "{excavators:?}"
        );
        assert!(
            excavators.contains(&"work-slope-4-deg".to_owned()),
            "{excavators:?}"
        );
        for names in [&mut excavators, &mut loaders] {
            assert_eq!(names[0], "work");
            let all = names.len();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), all);
        }
    }
}
