//! The command line.
#![expect(clippy::print_stderr, reason = "a command line talks to its user")]

#[macro_use]
mod say;
mod demo;
mod hubcap;
mod limit;

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Trimmed subdivision surfaces with exact borders, from files to files.
#[derive(Debug, Parser)]
#[command(name = "selvedge", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// A disc trimmed into a hubcap: the main job, on input that comes with the program. Also a control
    /// cage to its limit surface, and an octant fitted to its sphere.
    Demo {
        /// Where the files go.
        #[arg(long, default_value = "out")]
        out: PathBuf,
    },
    /// The limit surface of a control cage, as GLB, OBJ and a picture.
    Limit(limit::Arguments),
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    let result: Result<(), Box<dyn Error>> = match Arguments::parse().command {
        Command::Demo { out } => demo::run(&out),
        Command::Limit(arguments) => limit::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("selvedge: {why}");
            ExitCode::FAILURE
        }
    }
}
