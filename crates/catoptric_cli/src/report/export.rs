//! The table of a report as CSV, and as LaTeX.

use super::content::{Entry, Outcome, Report};
use super::table::{Column, Value, columns, rows};
use crate::failure::text::begins_formula;
use std::fmt::Write;

/// All columns that have values, as numbers in full, and why methods failed; lines end as RFC 4180 says.
pub(crate) fn csv(report: &Report) -> Vec<u8> {
    let columns = columns(report);
    let problem = |entry: &Entry| match &entry.outcome {
        Outcome::Failed(problem) => Some(problem.clone()),
        Outcome::Measured(measured) => measured.unusable.map(String::from),
    };
    let rows = rows(report);
    let has_problems = rows.iter().any(|row| problem(row.entry).is_some());
    let mut writer = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(Vec::new());
    let mut write = |cells: Vec<String>| {
        // Writing into memory does not fail.
        let _ = writer.write_record(cells);
    };
    let headings = std::iter::once("method").chain(columns.iter().map(|column| column.key));
    write(headings.chain(has_problems.then_some("problem")).map(String::from).collect());
    for row in rows {
        let mut cells = vec![plain_text(row.entry.label.clone())];
        cells.extend(columns.iter().map(|column| match column.value(report, row.entry) {
            Some(Value::Number(value)) => format!("{value}"),
            Some(Value::Text(text)) => plain_text(text),
            None => String::new(),
        }));
        cells.extend(has_problems.then(|| plain_text(problem(row.entry).unwrap_or_default())));
        write(cells);
    }
    writer.into_inner().unwrap_or_default()
}

/// Text that spreadsheets do not take for a formula.
fn plain_text(text: String) -> String {
    if begins_formula(&text) { format!("'{text}") } else { text }
}

/// A `tabular` of all columns that have values, rounded as in the page, the best ones bold; it needs no package.
pub(crate) fn latex(report: &Report) -> String {
    let columns = columns(report);
    let mut text = format!("% {}\n", report.command.replace(char::is_control, " "));
    let _ = writeln!(text, "\\begin{{tabular}}{{l{}}}\n\\hline", "r".repeat(columns.len()));
    let mut groups: Vec<(&str, usize)> = Vec::new();
    for column in &columns {
        match groups.last_mut() {
            Some((group, count)) if *group == column.group => *count += 1,
            _ => groups.push((column.group, 1)),
        }
    }
    for (group, count) in groups {
        let _ = write!(text, " & \\multicolumn{{{count}}}{{c}}{{{}}}", escaped(group));
    }
    text += " \\\\\nMethod";
    for column in &columns {
        let _ = write!(text, " & {}", escaped(column.heading));
    }
    text += " \\\\\n\\hline\n";
    for row in rows(report).iter().filter(|row| row.entry.measured().is_some()) {
        text += &escaped(&row.entry.label);
        for column in &columns {
            let cell = cell(column, report, row.entry);
            let _ = write!(text, " & {cell}");
        }
        text += " \\\\\n";
    }
    text + "\\hline\n\\end{tabular}\n"
}

fn cell(column: &Column, report: &Report, entry: &Entry) -> String {
    let text = escaped(&column.text(report, entry));
    if column.is_best(report, entry) { format!("\\textbf{{{text}}}") } else { text }
}

/// Text in which LaTeX finds no commands; of plain ASCII where it was that or one of the signs of the table.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '\\' => out += "\\textbackslash{}",
            '~' => out += "\\textasciitilde{}",
            '^' => out += "\\textasciicircum{}",
            '<' => out += "$<$",
            '>' => out += "$>$",
            '|' => out += "$|$",
            '"' => out += "''",
            '–' => out += "--",
            '×' => out += "$\\times$",
            '∞' => out += "$\\infty$",
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latex_finds_no_commands_in_names() {
        assert_eq!(
            escaped(r"a_b:{x}=5%&#$~^\"),
            r"a\_b:\{x\}=5\%\&\#\$\textasciitilde{}\textasciicircum{}\textbackslash{}"
        );
        assert_eq!(escaped("2.00×, – < 1 %"), r"2.00$\times$, -- $<$ 1 \%");
    }

    #[test]
    fn formulas_are_text() {
        assert_eq!(plain_text("=1+1".into()), "'=1+1");
        assert_eq!(plain_text("auto".into()), "auto");
    }
}
