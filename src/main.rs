//! The `nephrite` program: everything it does lives in [`nephrite::cli`].

fn main() -> std::process::ExitCode {
    nephrite::cli::main()
}
