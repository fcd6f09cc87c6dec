//! The command line: `selvedge demo`, `selvedge limit cage.obj`, `selvedge stages`.

use std::process::ExitCode;

fn main() -> ExitCode {
    selvedge::cli::main()
}
