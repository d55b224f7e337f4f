//! `docs/command-line.md` is what the parser says. To make it again: `UPDATE_DOCS=1 cargo test --test it command_page`.

use std::fmt::Write as _;
use std::path::Path;

use clap::{Arg, ArgAction, Command, CommandFactory as _};
use halfway::cli::Cli;

const PAGE: &str = "docs/command-line.md";

const HEAD: &str = "\
# The command line

Every subcommand with its flags and their defaults, as `halfway SUBCOMMAND --help` has them; `-h` is shorter. This page is
made from the parser: `UPDATE_DOCS=1 cargo test --test it command_page` makes it again.
";

/// Text of a cell: one line, words in angle brackets and bars as they are.
fn cell(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    lines.join(" ").replace('|', "\\|").replace('<', "&lt;")
}

/// `-o`, `--output FILE`, or `SCENE`.
fn name(arg: &Arg) -> String {
    let takes_values = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    let values: Vec<&str> = arg.get_value_names().into_iter().flatten().map(|name| name.as_str()).collect();
    let values = values.join(" ");
    let Some(long) = arg.get_long() else { return format!("`{values}`") };
    let is_optional = arg.get_num_args().is_some_and(|number| number.min_values() == 0);
    let value = match (takes_values, is_optional) {
        (false, _) => String::new(),
        (true, true) => format!(" [{values}]"),
        (true, false) => format!(" {values}"),
    };
    let short = arg.get_short().map_or(String::new(), |short| format!("`-{short}`, "));
    format!("{short}`--{long}{value}`")
}

/// The help, with what the possible values mean.
fn meaning(arg: &Arg) -> String {
    let help = arg.get_long_help().or(arg.get_help()).map(ToString::to_string).unwrap_or_default();
    let mut text = cell(&help);
    let values = if arg.get_action().takes_values() { arg.get_possible_values() } else { Vec::new() };
    let values: Vec<String> = values
        .iter()
        .filter(|value| !value.is_hide_set())
        .map(|value| {
            let help =
                value.get_help().map_or(String::new(), |help| format!(": {}", cell(&help.to_string())));
            format!("`{}`{help}", value.get_name())
        })
        .collect();
    if !values.is_empty() {
        write!(text, "<br>{}", values.join("<br>")).unwrap();
    }
    text
}

fn default(arg: &Arg) -> String {
    let values: Vec<_> = match arg.get_action().takes_values() {
        true => arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect(),
        false => Vec::new(),
    };
    if values.is_empty() { String::new() } else { format!("`{}`", values.join(",")) }
}

fn table(page: &mut String, args: &[&Arg]) {
    page.push_str("\n| | meaning | default |\n|---|---|---|\n");
    for arg in args {
        writeln!(page, "| {} | {} | {} |", name(arg), meaning(arg), default(arg)).unwrap();
    }
}

fn is_shown(arg: &Arg) -> bool {
    !arg.is_hide_set() && !["help", "version"].contains(&arg.get_id().as_str())
}

/// A section for each subcommand that does something, in the order of `--help`.
fn sections(page: &mut String, command: &Command, path: &str) {
    let path = format!("{path} {}", command.get_name());
    if command.has_subcommands() {
        let commands = command.get_subcommands().filter(|command| command.get_name() != "help");
        commands.for_each(|command| sections(page, command, &path));
        return;
    }
    let mut args: Vec<&Arg> =
        command.get_arguments().filter(|arg| is_shown(arg) && !arg.is_global_set()).collect();
    args.sort_by_key(|arg| !arg.is_positional());
    let about = command.get_long_about().or(command.get_about()).map(ToString::to_string).unwrap_or_default();
    let places: Vec<String> = args
        .iter()
        .filter(|arg| arg.is_positional())
        .map(|arg| {
            let name = arg.get_value_names().map_or("", |names| names[0].as_str());
            let more = if arg.get_num_args().is_some_and(|n| n.max_values() > 1) { "..." } else { "" };
            if arg.is_required_set() { format!(" {name}{more}") } else { format!(" [{name}{more}]") }
        })
        .collect();
    let options = if args.iter().any(|arg| !arg.is_positional()) { " [OPTIONS]" } else { "" };
    write!(page, "\n## `{path}`\n\n{about}\n\n    {path}{options}{}\n", &places.concat()).unwrap();
    if !args.is_empty() {
        table(page, &args);
    }
    if let Some(more) = command.get_after_long_help() {
        let more: String = more.to_string().lines().map(|line| format!("{line}\n")).collect();
        write!(page, "\n```text\n{more}```\n").unwrap();
    }
}

fn page() -> String {
    let mut command = Cli::command();
    command.build();
    let mut page = HEAD.to_owned();
    let commands = command.get_subcommands().filter(|command| command.get_name() != "help");
    commands.for_each(|command| sections(&mut page, command, "halfway"));
    page.push_str("\n## For all subcommands\n");
    let globals: Vec<&Arg> = command.get_arguments().filter(|arg| is_shown(arg)).collect();
    table(&mut page, &globals);
    if let Some(more) = command.get_after_long_help() {
        write!(page, "\n```text\n{}\n```\n", more.to_string().trim_end()).unwrap();
    }
    page
}

#[test]
fn command_page_is_what_the_parser_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let expected = page();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &expected).expect("a writable page");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    let different = found.lines().zip(expected.lines()).find(|(found, expected)| found != expected);
    assert!(
        found == expected,
        "{PAGE} is not what the parser says; make it again: UPDATE_DOCS=1 cargo test --test it command_page\n\
         the first line that differs: {different:#?}"
    );
}

/// What the parser would only find wrong when it is asked.
#[test]
fn command_page_has_a_meaning_for_every_flag() {
    Cli::command().debug_assert();
    let empty: Vec<String> = page()
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains("` |  | "))
        .map(str::to_owned)
        .collect();
    assert!(empty.is_empty(), "flags without a help text:\n{}", empty.join("\n"));
}
