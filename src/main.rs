//! The `halfway` command.

use std::process::ExitCode;

use clap::Parser;
use halfway::cli::{self, Cli};

fn main() -> ExitCode {
    let cli = Cli::parse();
    let level = match (cli.quiet, cli.verbose) {
        (true, _) => log::LevelFilter::Error,
        (false, 0) => log::LevelFilter::Warn,
        (false, 1) => log::LevelFilter::Info,
        (false, _) => log::LevelFilter::Debug,
    };
    // The graphics crates have much to say that is of no use to a renderer's user.
    env_logger::Builder::new()
        .filter_level(log::LevelFilter::Error)
        .filter_module("halfway", level)
        .parse_default_env()
        .format_timestamp(None)
        .format_target(false)
        .init();
    match cli::run(&cli) {
        Ok(exit) => exit.into(),
        Err(error) => {
            eprintln!("error: {error}");
            cli::Exit::from(error.fault()).into()
        }
    }
}
