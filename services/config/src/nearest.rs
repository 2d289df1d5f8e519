use strsim::osa_distance;

/// The name among `names` that `word` was probably meant to be: the one at the smallest edit
/// distance, if that is at most a third of the word's length (at least one edit). At least one letter must agree: `t` is no misspelt `x`.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = (word.chars().count() / 3).max(1);
    names
        .into_iter()
        .map(|name| {
            (
                osa_distance(&word.to_lowercase(), &name.to_lowercase()),
                name,
            )
        })
        .filter(|(distance, name)| {
            *distance <= limit && *distance < word.chars().count().max(name.chars().count())
        })
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_is_found_and_a_foreign_one_is_not() {
        let names = ["swing_velocity", "swing_torque", "boom_angle"];
        assert_eq!(nearest("swing_velocty", names), Some("swing_velocity"));
        assert_eq!(nearest("bmoo_angle", names), Some("boom_angle"));
        assert_eq!(nearest("Boom_Angle", names), Some("boom_angle"));
        assert_eq!(nearest("temperature", names), None);
        assert_eq!(nearest("t", ["x", "5", ""]), None);
        assert_eq!(nearest("t", ["x", "ts"]), Some("ts"));
    }
}
