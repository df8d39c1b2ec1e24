//! Compiles the robots: self-contained for `f32` and `f64`, and the arm also with `modyn-runtime` and as C.

use std::error::Error;
use std::path::Path;

use modyn_codegen::{Builder, FloatType, Function, Target};
use modyn_codegen::{ReadOptions, read};
use modyn_runtime::model::Model;

const FUNCTIONS: [Function; 5] = [
    Function::ForwardDynamics,
    Function::InverseDynamics,
    Function::MassMatrix,
    Function::Brge,
    Function::LinkPoses,
];

fn main() -> Result<(), Box<dyn Error>> {
    let out = std::env::var_os("OUT_DIR").ok_or("no OUT_DIR")?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    for (name, of) in [
        ("gripper", "gripper"),
        ("arm7", "arm7"),
        ("leg", "quadruped"),
        ("legs", "quadruped"),
        ("legs_shared", "quadruped"),
    ] {
        let path = folder.join(format!("{of}.urdf"));
        println!("cargo::rerun-if-changed={}", path.display());
        let text = std::fs::read_to_string(path)?;
        let file = format!("{of}.urdf");
        let model = read(&text, &file, &ReadOptions::default())?.model;
        let model = if name == "leg" { first_leg(&model)? } else { model };
        for (float, scalar) in [(FloatType::F32, "f32"), (FloatType::F64, "f64")] {
            let mut builder =
                Builder::new().model(model.clone()).scalar(float).functions(FUNCTIONS);
            if name == "legs_shared" {
                builder = builder.share_limbs();
            }
            let file = Path::new(&out).join(format!("{name}_{scalar}.rs"));
            builder.clone().self_contained().write(&file)?;
            if builder.is_stale(&file)? != true || builder.self_contained().is_stale(&file)? {
                return Err(
                    "the file that was just written must be up to date with its options".into()
                );
            }
        }
        if name == "arm7" {
            for (float, scalar) in [(FloatType::F32, "f32"), (FloatType::F64, "f64")] {
                let builder = Builder::new().model(model.clone()).scalar(float);
                for file in builder.functions(FUNCTIONS).emit(Target::C)?.files {
                    let end = file.name.rsplit('.').next().unwrap_or_default();
                    std::fs::write(
                        Path::new(&out).join(format!("arm7_{scalar}.{end}")),
                        file.text,
                    )?;
                }
                let builder = Builder::new().model(model.clone()).crate_("::modyn_runtime");
                let file = Path::new(&out).join(format!("ordinary_{scalar}.rs"));
                let builder = builder.scalar(float).functions([Function::ForwardDynamics]);
                builder.write(&file)?;
                let loaded = builder.runtime_gravity().runtime_inertia(["link7"]).payload(["hand"]);
                loaded.write(Path::new(&out).join(format!("loaded_{scalar}.rs")))?;
            }
        }
    }
    Ok(())
}

/// Returns the quadruped's first three joints with the frames that are fixed to their links: a leg on a stand.
fn first_leg(model: &Model) -> Result<Model, Box<dyn Error>> {
    let links = model.moving_links()[..3].to_vec();
    let own = |link: Option<usize>| link.is_none_or(|link| link < links.len());
    let frames = model.links().iter().filter(|link| own(link.moving_link)).cloned().collect();
    Model::new("leg", model.gravity(), links.clone(), frames)
        .map_err(|errors| errors[0].to_string().into())
}
