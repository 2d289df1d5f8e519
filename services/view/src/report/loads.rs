//! Loads as HTML: the section of a report, and a printable page.

use std::fmt::Write;

use estimation::loads::{Load, Truck, Weight};
use steps::loads::why_words;

use super::html::{self, text};
use crate::loads::{Account, clock, line, total_words, truck_line};
use crate::number::{grouped, interval_95, value_and_std};

/// The printable page: the loads of each truck, and the sum of the day.
pub fn loads_page(accounts: &[Account]) -> String {
    let mut body = String::from("<h1>Loads</h1>");
    for account in accounts {
        let _ = write!(
            body,
            "<h2>{}</h2><p class=\"facts\">{}, {}</p>",
            text(&account.name),
            account.machine,
            text(&total_words(&account.all))
        );
        facts(&mut body, account);
        for truck in &account.trucks {
            truck_table(&mut body, account, truck);
        }
        if let Some(load) = &account.carried {
            let line = text(&line(account.machine, load));
            let _ = write!(body, "<p>In the bucket at the end: {line}</p>");
        }
    }
    let _ = write!(
        body,
        "<p class=\"note\">{DELIVERED} Errors that all loads share (scale, offset, machine file) add up; those of each \
         load average out. Times are those of the recording.</p>"
    );
    html::page("heft report: loads", &body)
}

/// The loads of a recording for its report: the sum, and a row for each load.
pub(super) fn section(body: &mut String, account: &Account) {
    body.push_str("<section class=\"words loads\"><h2>Loads</h2>");
    let rows: Vec<&Load> = account.loads.iter().chain(&account.carried).collect();
    if rows.is_empty() {
        let lacks = account.lacks.map(|l| format!(" ({})", text(l)));
        let _ = write!(
            body,
            "<p>No load was clear of the empty bucket, carried and dumped{}.</p>",
            lacks.unwrap_or_default()
        );
        for outage in account.outages() {
            let _ = write!(body, "<p>{}</p>", text(&outage));
        }
        body.push_str("</section>");
        return;
    }
    if account.all.loads > 1 {
        let _ = write!(
            body,
            "<p>Delivered: {}.</p>",
            text(&total_words(&account.all))
        );
    }
    facts(body, account);
    let _ = write!(
        body,
        "{}<p class=\"note\">{DELIVERED} <code>heft loads</code> adds up trucks and days.</p></section>",
        table(account, &rows)
    );
}

/// Remarks on all loads: intervals that hold the truth, times without a weighed load, reasons against trust, values that the machine file does not state.
fn facts(body: &mut String, account: &Account) {
    let words = account.doubts().into_iter().chain(account.remarks());
    let words = words.map(|words| text(&words));
    for fact in account.covered_words().into_iter().chain(words) {
        let _ = write!(body, "<p>{fact}</p>");
    }
}

const DELIVERED: &str = "Delivered is what was in the bucket less what stayed in it.";

fn truck_table(body: &mut String, account: &Account, truck: &Truck) {
    let of_truck = account.loads.iter().filter(|l| l.truck == truck.number);
    let _ = write!(
        body,
        "<section class=\"words loads\"><h3>{}</h3>{}</section>",
        text(&truck_line(truck)),
        table(account, &of_truck.collect::<Vec<_>>())
    );
}

/// A row for each load; the truth only if known. A narrow screen hides the columns that its style names by position.
fn table(account: &Account, loads: &[&Load]) -> String {
    let mut head = vec![
        "load",
        "filled",
        "dumped",
        "in the bucket, kg",
        "95 %",
        "left in it, kg",
        "delivered, kg",
        "weighed by",
        "trusted",
    ];
    if !account.truths.is_empty() {
        head.insert(TRUTH_AT, "truth, kg");
    }
    let rows: String = loads.iter().map(|load| cells(account, load)).collect();
    html::table(1, &head, &rows)
}

/// Column of the truth, after the interval.
const TRUTH_AT: usize = 5;

fn cells(account: &Account, load: &Load) -> String {
    let kg = |weight: Weight| value_and_std(weight.kg, weight.std).0;
    let after_dump = |weight| load.dumped.map_or(String::new(), |_| kg(weight));
    let trusted = match load.trusted {
        true => "yes".to_owned(),
        false => format!("no: {}", text(why_words(account.machine, load))),
    };
    let mut cells = vec![
        load.number.to_string(),
        clock(load.filled),
        load.dumped.map_or("not yet".to_owned(), clock),
        kg(load.weight),
        interval_95(load.weight.kg, load.weight.std),
        after_dump(load.carry_back),
        after_dump(load.delivered()),
        load.witness.name().to_owned(),
        trusted,
    ];
    if !account.truths.is_empty() {
        let truth = account.truths.get(&load.number);
        cells.insert(TRUTH_AT, truth.map_or(String::new(), |t| grouped(*t, 0)));
    }
    html::row(&cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loads::account;

    #[test]
    fn the_page_says_what_the_truck_got_and_what_is_missing_and_lets_no_name_in_as_markup() {
        let text = loads_page(&[account()]);
        assert!(!text.contains("<i>"));
        for part in ["22\u{202f}906 kg missing", "22 906 kg missing"] {
            let plain = text.replace(['\u{a0}', '\u{202f}'], " ");
            assert!(plain.contains(&part.replace('\u{202f}', " ")), "{plain}");
        }
        assert!(text.contains("12.7"));
    }

    #[test]
    fn a_load_in_the_bucket_has_nothing_left_or_delivered_yet_and_none_says_what_lacks() {
        let mut account = account();
        let mut body = String::new();
        section(&mut body, &account);
        assert!(body.contains("<td>0:12.7</td>"), "{body}");
        assert!(body.contains("no: the bucket"), "{body}");
        let mut carried = account.loads.remove(0);
        carried.dumped = None;
        account.carried = Some(carried);
        body.clear();
        section(&mut body, &account);
        assert!(body.contains("<td>not yet</td>"), "{body}");
        assert!(body.contains("<td></td><td></td>"), "{body}");
        account.guessed = Some("Lengths are guessed.".to_owned());
        body.clear();
        section(&mut body, &account);
        assert!(body.contains("<p>Lengths are guessed.</p>"), "{body}");
        (account.carried, account.lacks) = (None, Some("map the pressures"));
        body.clear();
        section(&mut body, &account);
        assert!(
            !body.contains("<table") && body.contains("(map the pressures)"),
            "{body}"
        );
        account.outages = vec![steps::loads::Outage::default()];
        body.clear();
        section(&mut body, &account);
        assert!(body.contains("no load was weighed"), "{body}");
    }

    #[test]
    fn the_truth_has_a_column_only_where_it_is_known_and_says_how_many_intervals_hold_it() {
        let mut account = account();
        let page = |account: &Account| {
            let mut body = String::new();
            section(&mut body, account);
            body
        };
        assert!(!page(&account).contains("truth"), "{}", page(&account));
        account.truths.insert(1, 1100.4);
        let unreported = page(&account);
        assert!(unreported.contains("<th>truth, kg</th>"), "{unreported}");
        assert!(unreported.contains("<td>1\u{a0}100</td>"), "{unreported}");
        assert!(!unreported.contains("The truth lies"), "{unreported}");
        account.loads[0].trusted = true;
        assert!(page(&account).contains("inside 1 of 1 intervals"));
        let printed = loads_page(&[account.clone()]);
        assert!(printed.contains("inside 1 of 1 intervals"), "{printed}");
        account.truths.insert(1, 1300.0);
        assert!(page(&account).contains("inside 0 of 1 intervals"));
        account.loads[0].number = 2;
        assert!(page(&account).contains("<td></td>"), "a load without truth");
    }
}
