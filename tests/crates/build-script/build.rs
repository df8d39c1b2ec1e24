//! Compiles several robots: one by its file, one with a type name, and one with an axis of wrong length, which causes a
//! warning of Cargo.
use modyn_codegen::diagnostics::{Code, Diagnostics};
use modyn_codegen::{Builder, FloatType};

fn main() -> Result<(), Diagnostics> {
    let builder = Builder::new().urdf("robots/my-robot.urdf");
    builder.compile()?;
    let same = builder.clone().scalar(FloatType::F32).compile().expect_err("the same name");
    assert!(same.iter().all(|error| error.code == Code::Output), "{same}");
    builder.clone().type_name("LightArm").scalar(FloatType::F32).compile()?;
    let text = std::fs::read_to_string("robots/my-robot.urdf").expect("is there");
    let odd = Builder::new().urdf_text(text.replace("0 1 0", "0 2 0"), "odd.urdf");
    odd.type_name("Odd").visibility("pub(crate)").compile()?;
    Ok(())
}
