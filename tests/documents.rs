//! README and docs: sentences are short, links are valid, and commands exist.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Largest number of words of a sentence.
const LONGEST_SENTENCE: usize = 25;
/// Largest number of words of a page; a longer page is to be split.
const LONGEST_PAGE: usize = 1200;

/// README and every page of docs.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/theory", "docs/measurements"] {
        let entries = std::fs::read_dir(root.join(folder)).expect("a folder");
        let paths = entries.map(|e| e.expect("an entry").path());
        pages.extend(paths.filter(|p| p.extension().is_some_and(|e| e == "md")));
    }
    pages.sort();
    pages
}

/// The text outside of fences, and the text within.
fn split(text: &str) -> (Vec<&str>, Vec<&str>) {
    let (mut words, mut fenced, mut inside) = (Vec::new(), Vec::new(), false);
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
            words.push("");
        } else if inside {
            fenced.push(line);
        } else {
            words.push(line);
        }
    }
    (words, fenced)
}

/// Units of text: paragraphs, points of lists and cells of tables.
fn pieces(lines: &[&str]) -> Vec<String> {
    let mut all = vec![String::new()];
    for line in lines.iter().map(|l| l.trim()) {
        let is_point = line.starts_with("* ")
            || line.starts_with("- ")
            || line
                .split_once(". ")
                .is_some_and(|(n, _)| n.parse::<u32>().is_ok());
        if line.starts_with('|') {
            all.extend(line.split('|').map(str::to_owned));
            all.push(String::new());
        } else if line.is_empty() || line.starts_with('#') || line.starts_with('<') {
            all.push(String::new());
        } else {
            if is_point {
                all.push(String::new());
            }
            let last = all.last_mut().expect("never empty");
            last.push(' ');
            last.push_str(line);
        }
    }
    all
}

/// Text between back quotes counts as one word, the address of a link as none.
fn without_code(text: &str) -> String {
    let quoted = text.split('`').enumerate();
    let text: String = quoted
        .map(|(i, part)| if i % 2 == 1 { "X" } else { part })
        .collect();
    let mut parts = text.split("](");
    let first = parts.next().unwrap_or_default().to_owned();
    let rest = parts.map(|p| p.split_once(')').map_or(p, |(_, after)| after));
    first + &rest.collect::<String>()
}

fn sentences(piece: &str) -> Vec<String> {
    let mut all = vec![String::new()];
    for word in without_code(piece).split_whitespace() {
        let last = all.last_mut().expect("never empty");
        last.push(' ');
        last.push_str(word);
        let end = word.trim_end_matches([')', '"', '*', '_']);
        if end.ends_with(['.', '?', '!']) && end != "e.g." {
            all.push(String::new());
        }
    }
    all
}

fn length(sentence: &str) -> usize {
    let words = sentence.split_whitespace();
    words
        .filter(|w| w.chars().any(char::is_alphanumeric))
        .count()
}

#[test]
fn no_sentence_is_too_long_to_read() {
    let mut long = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page");
        let all = pieces(&split(&text).0);
        let all = all.iter().flat_map(|p| sentences(p));
        long.extend(
            all.filter(|s| length(s) > LONGEST_SENTENCE)
                .map(|s| format!("{}: {} words:{s}", page.display(), length(&s))),
        );
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn no_page_is_too_long_to_read() {
    let mut long = Vec::new();
    for page in pages() {
        // The generated reference and the journals of measurements are excluded.
        let is_journal = page.parent().is_some_and(|f| f.ends_with("measurements"));
        if page.ends_with("docs/messages.md") || is_journal {
            continue;
        }
        let text = std::fs::read_to_string(&page).expect("a page");
        let words = text.split_whitespace().count();
        if words > LONGEST_PAGE {
            long.push(format!("{}: {words} words", page.display()));
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn the_summary_of_the_site_lists_every_page_of_docs_once() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let summary = std::fs::read_to_string(docs.join("SUMMARY.md")).expect("a summary");
    let links = summary.split("](").skip(1);
    let mut listed: Vec<PathBuf> = links
        .filter_map(|rest| rest.split_once(')'))
        .map(|(page, _)| docs.join(page))
        .collect();
    listed.sort();
    let is_page = |p: &PathBuf| p.starts_with(&docs) && !p.ends_with("SUMMARY.md");
    let expected: Vec<PathBuf> = pages().into_iter().filter(is_page).collect();
    assert_eq!(listed, expected);
}

/// Numbers of a text, without their markup.
fn numbers(text: &str) -> Vec<&str> {
    let parts = text.split(|c: char| !c.is_ascii_digit() && c != '.');
    let bare = parts.map(|part| part.trim_end_matches('.'));
    bare.filter(|part| part.chars().any(|c| c.is_ascii_digit()))
        .collect()
}

#[test]
fn every_share_of_the_known_failures_stands_in_the_page_that_its_row_names() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let read = |page: &str| std::fs::read_to_string(docs.join(page)).expect("a page");
    let (mut seen, mut missing) = (0, Vec::new());
    for row in read("known-failures.md").lines() {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, _, shares, .., source, _] = cells[..] else {
            continue;
        };
        let Some((_, target)) = source.split_once("](") else {
            continue;
        };
        let page = target.split(['#', ')']).next().unwrap_or_default();
        let text = read(page);
        let known = numbers(&text);
        for number in numbers(shares) {
            seen += 1;
            if !known.contains(&number) {
                missing.push(format!("{number} is not in {page}: {row}"));
            }
        }
    }
    assert!(seen > 50, "{seen} shares");
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

#[test]
fn a_long_sentence_is_found_and_code_is_one_word() {
    let words = "word ".repeat(31);
    assert_eq!(length(&sentences(&words)[0]), 31);
    // Colons and semicolons end no sentence.
    assert_eq!(length(&sentences("one: two; three four.")[0]), 4);
    assert_eq!(length(&sentences("run `heft a b c` now.")[0]), 3);
    assert_eq!(
        length(&sentences("see [a page](with/a/path.md) here")[0]),
        4
    );
}

/// Anchors of the headings of a page: small letters, digits, and hyphens for blanks.
fn anchors(page: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(page).expect("a page");
    let headings = split(&text).0.into_iter().filter(|l| l.starts_with('#'));
    let kept = |c: char| c.is_alphanumeric() || "-_ ".contains(c);
    let name = |heading: &str| heading.trim_start_matches('#').trim().to_lowercase();
    let names = headings.map(|h| name(h).chars().filter(|c| kept(*c)).collect::<String>());
    names.map(|name| name.replace(' ', "-")).collect()
}

#[test]
fn every_link_of_a_page_leads_to_a_file_and_to_a_heading() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .canonicalize()
        .expect("docs");
    let mut broken = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page");
        for target in text.split("](").skip(1).filter_map(|t| t.split(')').next()) {
            if target.starts_with("http") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let found = match file {
                "" => page.canonicalize(),
                file => page.parent().expect("a folder").join(file).canonicalize(),
            };
            // A page of the site can link only to files within docs.
            let is_shown = |f: &PathBuf| !page.starts_with(&docs) || f.starts_with(&docs);
            let is_there =
                |f: &PathBuf| anchor.is_empty() || anchors(f).iter().any(|a| a == anchor);
            if !found.is_ok_and(|f| is_shown(&f) && is_there(&f)) {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

fn heft(arguments: &[&str]) -> std::process::Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_heft"));
    command.args(arguments).output().expect("heft runs")
}

/// Commands of heft in a text: from the word `heft` to the end of the line, of the quotation or of the pipe.
fn commands(text: &str) -> Vec<Vec<String>> {
    let (lines, fenced) = split(text);
    let joined = fenced.join("\n").replace("\\\n", " ");
    let fenced = joined.lines().map(str::to_owned);
    let quoted = lines
        .iter()
        .flat_map(|line| line.split('`').skip(1).step_by(2));
    let all = fenced.chain(quoted.map(str::to_owned));
    let mut found = Vec::new();
    for line in all {
        let words: Vec<String> = line
            .split('#')
            .next()
            .unwrap_or_default()
            .split_whitespace()
            .map(|w| w.trim_end_matches([';', '&', ',']).to_owned())
            .collect();
        for (i, _) in words.iter().enumerate().filter(|(_, w)| *w == "heft") {
            let until = |w: &&String| !["|", ">", "<", "&", ""].contains(&w.as_str());
            found.push(words[i + 1..].iter().take_while(until).cloned().collect());
        }
    }
    found
}

/// The commands in README and docs: the subcommand exists, and so does every option. They are not run here, because
/// they need data, a bus or minutes; those without needs run in the next test.
#[test]
fn every_command_of_the_pages_exists_with_its_options() {
    let mut helps: BTreeMap<String, String> = BTreeMap::new();
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page");
        for words in commands(&text) {
            // `heft fleet` is a separate program; capitals and dots are placeholders.
            let Some(name) = words
                .first()
                .filter(|w| w.chars().all(|c| c.is_ascii_lowercase()))
            else {
                continue;
            };
            let known = heft(&[name, "--help"]);
            let is_prose = words.len() == 1 && !known.status.success();
            if name == "fleet" || is_prose {
                continue;
            }
            seen += 1;
            let help = helps
                .entry(name.clone())
                .or_insert_with(|| String::from_utf8_lossy(&known.stdout).into_owned());
            for option in words.iter().filter(|w| w.starts_with("--") && w.len() > 2) {
                let option = option.split('=').next().unwrap_or_default();
                let option = option.trim_end_matches(|c: char| !c.is_ascii_alphanumeric());
                let option = option.split('[').next().unwrap_or_default();
                let is_whole = |word: &str| {
                    let word = word.trim_matches(|c: char| !c.is_ascii_alphanumeric() && c != '-');
                    word.split(['=', '[']).next() == Some(option)
                };
                if !help.split_whitespace().any(is_whole) {
                    wrong.push(format!(
                        "{}: heft {}: {option}",
                        page.display(),
                        words.join(" ")
                    ));
                }
            }
            if !known.status.success() {
                wrong.push(format!("{}: heft {}", page.display(), words.join(" ")));
            }
        }
    }
    assert!(seen > 30, "{seen} commands found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_command_of_the_bench_in_the_pages_is_one_of_its_usage() {
    let main = Path::new(env!("CARGO_MANIFEST_DIR")).join("bench/src/main.rs");
    let main = std::fs::read_to_string(main).expect("the program");
    let mut seen = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page");
        for words in text.split("-p bench -- ").skip(1) {
            let is_letter = |c: char| c.is_ascii_lowercase();
            let word = words.split(|c| !is_letter(c)).next().unwrap_or_default();
            seen += 1;
            let known = main.contains(&format!("       bench {word} "));
            assert!(known, "{}: bench -- {word}", page.display());
        }
    }
    assert!(seen > 1, "{seen} commands found");
}

#[test]
fn commands_that_need_nothing_run() {
    for arguments in [
        "check --machine excavator --print",
        "check --machine loader --print",
        "schema --lang dbc",
        "schema --lang c",
        "schema --lang python",
        "schema --lang proto",
        "schema --lang json",
        "run excavator --scenario list",
        "run loader --scenario list",
    ] {
        let words: Vec<&str> = arguments.split(' ').collect();
        let output = heft(&words);
        assert!(output.status.success(), "heft {arguments}");
        assert!(output.stdout.len() > 100, "heft {arguments}");
    }
}

#[test]
fn the_machine_files_of_the_pages_are_valid() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("machine.toml");
    let mut seen = 0;
    for page in pages() {
        let text = std::fs::read_to_string(&page).expect("a page");
        let blocks = text.split("```toml\n").skip(1);
        let blocks = blocks.filter_map(|rest| rest.split("```").next());
        for block in blocks.filter(|block| block.contains("[machine]\n")) {
            std::fs::write(&file, block).expect("a file");
            let machine = if block.contains("wheelbase") {
                "loader"
            } else {
                "excavator"
            };
            let path = file.to_str().expect("a path");
            let output = heft(&["check", path, "--machine", machine]);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {said}", page.display());
            seen += 1;
        }
    }
    assert!(seen > 1, "{seen} machine files found");
}

/// Runs the commands of a page that simulate a machine and calibrate it, as written there; returns the output of the calibration.
fn simulated_calibration(page: &str) -> (tempfile::TempDir, String) {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join(page);
    let text = std::fs::read_to_string(page).expect("a page");
    let block = text.split("```").find(|b| b.contains("--scenario"));
    let block = format!("```\n{}\n```", block.expect("commands").trim());
    let folder = tempfile::tempdir().expect("a folder");
    let mut said = String::new();
    for words in commands(&block) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_heft"));
        let output = command.args(&words).current_dir(folder.path()).output();
        let output = output.expect("heft runs");
        said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "heft {}: {said}", words.join(" "));
    }
    (folder, said)
}

#[test]
fn who_tries_a_calibration_as_the_pages_say_finds_the_cylinders_too() {
    for (page, key) in [
        ("docs/calibrate.md", "[machine.boom_cylinder]"),
        ("docs/calibrate-loader.md", "[machine.lift_arm.cylinder]"),
    ] {
        let (folder, said) = simulated_calibration(page);
        let file = std::fs::read_to_string(folder.path().join("m.toml")).expect("a machine file");
        let (_, cylinder) = file.split_once(key).expect("cylinders");
        let area = cylinder.lines().find(|line| line.starts_with("head_area"));
        assert!(
            area.is_some_and(|line| line.contains("calibrated")),
            "{page}: {said}"
        );
    }
}
