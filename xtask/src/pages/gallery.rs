//! The gallery of the robots in `robots/`.

use modyn_codegen::{Builder, Function};

use super::data::{Data, table};
use super::{files, root};

/// The robots whose numbers are those of a description in `docs/data/robots.tsv`.
const SOURCES: [(&str, &str, &str); 4] = [
    ("arm6", "UR5", "ur_description/urdf/ur5_robot"),
    ("arm7", "Panda", "panda_description/urdf/panda"),
    ("quadruped", "Solo12", "solo_description/robots/solo12"),
    ("humanoid", "G1", "g1_description/urdf/g1_29dof_rev_1_0"),
];

/// Returns a table with a row for each robot: its picture and operations.
pub(super) fn table_of_robots() -> String {
    let compared = Data::load("robots");
    let rows = files("robots", ".urdf").into_iter().map(|path| {
        let name = path["robots/".len()..path.len() - ".urdf".len()].to_owned();
        let functions =
            [Function::ForwardDynamics, Function::InverseDynamics, Function::MassMatrix];
        let builder = Builder::new().urdf(root(&path)).functions(functions);
        let generated = builder.generate().unwrap_or_else(|found| panic!("{path}: {found}"));
        let operations = |function: &str| {
            let found = generated.operations.iter().find(|(one, _)| *one == function);
            found.expect("a function").1.total().to_string()
        };
        let source = SOURCES.iter().find(|(one, _, _)| *one == name);
        let source = source.map_or(String::new(), |(_, title, file)| {
            format!("{title}: {}", compared.cell(&[file], "accelerations"))
        });
        [
            format!("![{name}](../docs/figures/robots/{name}.svg)"),
            format!("`{name}`"),
            operations("forward_dynamics"),
            operations("inverse_dynamics"),
            operations("mass_matrix"),
            source,
        ]
    });
    let titles = "picture | robot | forward dynamics | inverse dynamics | mass matrix \
        | the source's description: accelerations beside Pinocchio";
    table(titles, rows)
}
