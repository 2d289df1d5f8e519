//! Statements of the user on the recordings: masses, and readings of axle scales.

use std::path::Path;

use estimation::Quantity;

use super::args::CalibrateArgs;
use crate::failure::Failure;

/// The recording, if one is named, and the file of scales in `[FILE=]SCALES`.
pub fn scales(text: &str) -> (Option<&str>, &Path) {
    match text.rsplit_once('=') {
        None => (None, Path::new(text)),
        Some((file, scales)) => (Some(file), Path::new(scales)),
    }
}

/// The load of each file: `FILE=KG`, `FILE=KG±KG` or `FILE=KG+-KG`.
pub fn stated(
    args: &CalibrateArgs,
    given: &[String],
    option: &str,
) -> Result<Vec<Option<Quantity>>, Failure> {
    let mut loads = vec![None; args.files.len()];
    for text in given {
        let bad = |what: String| {
            Failure::input(
                what,
                format!("{option} {text}"),
                format!("write it like {option} loaded.mcap=423±2"),
            )
        };
        let Some((file, load)) = text.rsplit_once('=') else {
            return Err(bad("no = between file and mass".into()));
        };
        let at = position(args, file, option, text)?;
        let load = quantity(load).ok_or_else(|| bad(format!("{load} is no mass")))?;
        if loads[at].replace(load).is_some() {
            return Err(bad(format!("{file} is stated twice")));
        }
    }
    Ok(loads)
}

/// The pairs of recordings out and back: `FILE,FILE`.
pub fn out_and_back(args: &CalibrateArgs) -> Result<Vec<[usize; 2]>, Failure> {
    const OPTION: &str = "--out-and-back";
    let pair = |text: &String| {
        let bad = |what| {
            Failure::input(
                what,
                format!("{OPTION} {text}"),
                format!("write it like {OPTION} flat.mcap,back.mcap"),
            )
        };
        let (there, back) = text
            .split_once(',')
            .ok_or_else(|| bad("no comma between two recordings"))?;
        let there = position(args, there, OPTION, text)?;
        let back = position(args, back, OPTION, text)?;
        if there == back {
            return Err(bad("the same recording twice"));
        }
        Ok([there, back])
    };
    args.there_and_back.iter().map(pair).collect()
}

/// Index of a recording, by its name, by the end of its path, or by the folder of its run.
pub fn position(
    args: &CalibrateArgs,
    file: &str,
    option: &str,
    text: &str,
) -> Result<usize, Failure> {
    let bad = |what: &str, remedy: String| {
        Failure::input(
            format!("{file} is {what}"),
            format!("{option} {text}"),
            remedy,
        )
    };
    let is_folder = |f: &Path| f.parent().is_some_and(|p| p.ends_with(file));
    let is_meant = |f: &Path| !file.is_empty() && (f.ends_with(file) || is_folder(f));
    let mut meant = (0..args.files.len()).filter(|&i| is_meant(&args.files[i]));
    match (meant.next(), meant.next()) {
        (Some(at), None) => Ok(at),
        (None, _) => {
            let names: Vec<_> = args.files.iter().map(|f| f.display().to_string()).collect();
            let remedy = format!("name one as it stands in the command: {}", names.join(", "));
            Err(bad("none of the recordings", remedy))
        }
        (Some(_), Some(_)) => Err(bad(
            "more than one of the recordings",
            "name its folder too".to_owned(),
        )),
    }
}

/// A mass with its standard deviation, both not negative.
fn quantity(text: &str) -> Option<Quantity> {
    let (value, std) = text
        .split_once('±')
        .or_else(|| text.split_once("+-"))
        .unwrap_or((text, "0"));
    let number = |t: &str| {
        t.trim()
            .parse::<f64>()
            .ok()
            .filter(|v| v.is_finite() && *v >= 0.0)
    };
    Some(Quantity {
        value: number(value)?,
        std: number(std)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_is_meant_by_its_name_its_folder_or_both() {
        use clap::Parser;
        let words = "heft calibrate excavator runs/empty/run.mcap runs/full/run.mcap b.csv -o x";
        let cli = crate::commands::Cli::parse_from(words.split(' '));
        let Some(crate::commands::Command::Calibrate(args)) = cli.command else {
            panic!("calibrate");
        };
        let at = |file: &str| position(&args, file, "--payload", "").ok();
        assert_eq!(
            ["b.csv", "empty", "full/run.mcap"].map(at),
            [Some(2), Some(0), Some(1)]
        );
        assert_eq!(["run.mcap", "runs/b.csv", "", "un.mcap"].map(at), [None; 4]);
    }

    #[test]
    fn a_load_is_read_in_three_ways() {
        let load = |value, std| Some(Quantity { value, std });
        assert_eq!(quantity("423"), load(423.0, 0.0));
        assert_eq!(quantity("423±2"), load(423.0, 2.0));
        assert_eq!(quantity("423.5 +- 2"), load(423.5, 2.0));
        for bad in ["", "x", "-1", "1±x", "nan", "1±-2"] {
            assert_eq!(quantity(bad), None, "{bad}");
        }
    }
}
