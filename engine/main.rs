//! The command line: `selvedge demo`, `selvedge limit cage.obj`.

use std::process::ExitCode;

fn main() -> ExitCode {
    selvedge::cli::main()
}
