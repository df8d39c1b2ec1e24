//! A function that was not generated can be named but not called. The generated type has a method with the name and
//! the number of arguments of that function, and the method's bound does not hold.

use std::collections::BTreeMap;
use std::path::Path;

use modyn_codegen::plan::Sizes;
use modyn_codegen::{Builder, Function};

/// Returns the functions of the robot's type by name, with their number of arguments: the hidden ones or the others.
fn functions(text: &str, hidden: bool) -> BTreeMap<String, usize> {
    fn walk(items: &[syn::Item], hidden: bool, found: &mut BTreeMap<String, usize>) {
        for item in items {
            match item {
                syn::Item::Const(item) => {
                    if let syn::Expr::Block(block) = &*item.expr {
                        let items =
                            block.block.stmts.iter().filter_map(|statement| match statement {
                                syn::Stmt::Item(item) => Some(item.clone()),
                                _ => None,
                            });
                        walk(&items.collect::<Vec<_>>(), hidden, found);
                    }
                }
                syn::Item::Impl(item) if item.trait_.is_none() => {
                    let syn::Type::Path(path) = &*item.self_ty else { continue };
                    if !path.path.is_ident("Robot") {
                        continue;
                    }
                    for item in &item.items {
                        let syn::ImplItem::Fn(function) = item else { continue };
                        let is_hidden = function.sig.generics.where_clause.is_some();
                        if is_hidden == hidden {
                            found.insert(function.sig.ident.to_string(), function.sig.inputs.len());
                        }
                    }
                }
                _ => {}
            }
        }
    }
    let mut found = BTreeMap::new();
    walk(&syn::parse_file(text).expect("Rust").items, hidden, &mut found);
    found
}

#[test]
fn missing_functions_have_the_arguments_of_those_that_are_there() {
    for robot in ["four_bar", "double_pendulum"] {
        for parameters in [false, true] {
            let path =
                Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../robots/{robot}.urdf"));
            let builder = Builder::new().urdf(path).type_name("Robot");
            let builder = if parameters { builder.runtime_gravity() } else { builder };
            let all = builder.clone().functions(Function::ALL.iter().copied()).generate();
            let none = builder.functions([]).generate().expect("good").text;
            let all = all.expect("good").text;
            let there = functions(&all, false);
            assert!(there.len() > 40, "{there:?}");
            // The check of unit quaternions belongs to no function of the option.
            let always = functions(&none, false);
            assert!(always.keys().all(|name| name == "check_configuration"), "{always:?}");
            let missing = functions(&none, true);
            for (name, arguments) in &there {
                let found = missing.get(name).or_else(|| always.get(name));
                assert_eq!(found, Some(arguments), "{robot}: {name}");
            }
            // A tree has no constraints, no actuators and touches no ground, so their functions are never selected.
            let is_special = |name: &String| {
                let one = ["_with", "_batch", "_each"]
                    .iter()
                    .fold(&**name, |name, end| name.strip_suffix(end).unwrap_or(name));
                Function::from_name(one).is_some_and(|one| !one.row().is_general())
            };
            let rest = missing.keys().filter(|name| !there.contains_key(*name));
            assert!(rest.clone().all(is_special), "{:?}", rest.collect::<Vec<_>>());
            // A generated function is not also a missing one, and the traits are those of the generated functions.
            let hidden = functions(&all, true);
            assert!(hidden.keys().all(|name| !there.contains_key(name)), "{hidden:?}");
            for function in Function::ALL {
                let line = format!("impl __modyn::functions::{function:?} for Robot {{}}");
                let constraints = usize::from(robot == "four_bar");
                let has = function.fits(&Sizes { constraints, ..Sizes::default() });
                assert_eq!(
                    (all.contains(&line), none.contains(&line)),
                    (has, false),
                    "{function:?}"
                );
            }
        }
    }
}
