//! Results that commands write: completely or not at all, and only over an earlier result of the same command.

use std::path::Path;

use recording::Output;
use serde_json::Value;

use crate::failure::Failure;

/// Writes a text. `is_ours` recognizes an earlier result by its first bytes; `doing` names the task: "write the page".
pub fn text(
    doing: &'static str,
    path: &Path,
    inputs: &[&Path],
    is_ours: impl Fn(&[u8]) -> bool,
    text: &str,
) -> Result<(), Failure> {
    let mut out = Output::create(doing, path, inputs, is_ours)?;
    out.put(text.as_bytes())?;
    Ok(out.finish()?)
}

/// Recognizes an earlier result by its first bytes.
pub type IsOurs<'a> = &'a dyn Fn(&[u8]) -> bool;

/// Refuses to overwrite an input (`taken`) or any other valuable file, or to write two results to one file.
pub fn check<'a>(
    mut taken: Vec<&'a Path>,
    wanted: &[(Option<&'a Path>, IsOurs)],
) -> Result<(), Failure> {
    let whole = |p: &Path| std::path::absolute(p).ok();
    for (result, is_ours) in wanted {
        let Some(result) = result else { continue };
        if taken.iter().any(|t| whole(t) == whole(result)) {
            return Err(Failure::input(
                "two results, or a result and an input, have the same name",
                result.display(),
                "choose another name",
            ));
        }
        recording::output::check(result, &taken, is_ours)?;
        taken.push(result);
    }
    Ok(())
}

/// Writes a JSON object. Its first key, `heft`, names the command and `by`; a value that is no object is put under
/// `rows`.
pub fn json(
    path: &Path,
    inputs: &[&Path],
    command: &'static str,
    by: &str,
    value: &Value,
) -> Result<(), Failure> {
    let whole = signed(command, by, value).map_err(Failure::internal)?;
    text(
        "write the result",
        path,
        inputs,
        is_json_of(command),
        &whole,
    )
}

fn signed(command: &str, by: &str, value: &Value) -> serde_json::Result<String> {
    let made = serde_json::to_string(&format!("heft {command} {by}"))?;
    let body = match value {
        Value::Object(_) => serde_json::to_string_pretty(value)?,
        rows => serde_json::to_string_pretty(&serde_json::json!({ "rows": rows }))?,
    };
    let rest = body.strip_prefix('{').unwrap_or(&body);
    let comma = if rest == "}" { "\n" } else { "," };
    Ok(format!("{{\n  \"heft\": {made}{comma}{rest}\n"))
}

/// Recognizes JSON of a command of heft by its first bytes.
pub fn is_json_of(command: &str) -> impl Fn(&[u8]) -> bool {
    let first = format!("{{\n  \"heft\": \"heft {command} ");
    move |head| head.starts_with(first.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn json_says_first_who_made_it() {
        for value in [json!({"a": 1, "z": [2.5]}), json!({})] {
            let text = signed("weigh", "0.1 \"dirty\"", &value).unwrap();
            assert!(is_json_of("weigh")(text.as_bytes()));
            assert!(!is_json_of("evaluate")(text.as_bytes()));
            let mut read: Value = serde_json::from_str(&text).unwrap();
            let made = read.as_object_mut().unwrap().remove("heft");
            assert_eq!(made, Some(json!("heft weigh 0.1 \"dirty\"")));
            assert_eq!(read, value);
        }
        let text = signed("evaluate", "0.1", &json!([{"a": 1}])).unwrap();
        let read: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(read["rows"], json!([{"a": 1}]));
    }
}
