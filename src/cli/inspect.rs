//! `nephrite inspect`
use super::Failure;
use super::args::InspectArgs;
pub(super) fn run(args: &InspectArgs) -> Result<(), Failure> {
    let _ = super::pipeline::load(&args.input, args.scene, false)?;
    println!("{}", args.json);
    Ok(())
}
