//! How the command line and the examples print.

/// Prints a line, as `println!` does. Where nobody reads any more, as when `head` has seen enough, the
/// program ends there, and well; other failures to write end it too, with 1.
macro_rules! say {
    ($($line:tt)*) => {{
        use std::io::Write as _;
        if let Err(why) = writeln!(std::io::stdout().lock(), $($line)*) {
            std::process::exit(i32::from(why.kind() != std::io::ErrorKind::BrokenPipe));
        }
    }};
}
