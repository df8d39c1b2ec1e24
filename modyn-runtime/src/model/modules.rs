//! The kinematic module tree of the paper (Sect. 2).
//!
//! A kinematic module is a serial chain of links that starts at the last link of its parent module.
//! In depth-first order its links are consecutive.

use alloc::{collections::BTreeMap, string::String, vec::Vec};
use core::{fmt, ops::Range};

use super::Model;

/// A kinematic module: a serial chain of consecutive links.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Module {
    /// The module's links, from the parent module to the tip.
    pub links: Range<usize>,
    /// The module whose last link carries this module; `None` for the world.
    pub parent: Option<usize>,
    /// The modules that are carried by this module's last link.
    pub children: Vec<usize>,
}

/// A partition of a model's links into kinematic modules, parents before children.
///
/// ```
/// # let model = include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/pendulum.in"));
/// use modyn_runtime::model::ModuleTree;
///
/// let chains = ModuleTree::chains(&model);
/// assert_eq!(chains.modules().len(), 1);
/// assert_eq!(ModuleTree::from_names(&model, &[vec!["rod"]]), Ok(chains));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleTree {
    modules: Vec<Module>,
}

/// A reason why a list of modules is not a partition into chains.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModuleError {
    /// The name does not belong to a moving link.
    UnknownLink {
        /// The name in the list.
        name: String,
        /// The names of the first moving links.
        links: Vec<String>,
    },
    /// The link is listed twice.
    Twice(String),
    /// The link is in no module.
    Missing(String),
    /// The second link follows the first in a module, but is not its child.
    NotSerial {
        /// The first link.
        before: String,
        /// The second link.
        link: String,
        /// The parent of the second link.
        parent: String,
    },
    /// A module contains links after a link at which another module starts.
    BranchInside {
        /// The link inside the module at which the tree branches.
        at: String,
        /// The link of the other module that starts there.
        leaving: String,
    },
    /// A module is empty.
    Empty,
}

/// The largest number of names in a message.
const SHOWN: usize = 40;

impl fmt::Display for ModuleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownLink { name, links } => {
                write!(
                    f,
                    "`{name}` in the module list is not a moving link; the moving links are: {}{}",
                    links.join(", "),
                    if links.len() < SHOWN { "" } else { ", ..." }
                )
            }
            Self::Twice(link) => {
                write!(
                    f,
                    "link `{link}` is listed in the modules twice; each link belongs to one module"
                )
            }
            Self::Missing(link) => {
                write!(
                    f,
                    "link `{link}` is in no module; the modules must contain every moving link"
                )
            }
            Self::NotSerial { before, link, parent } => write!(
                f,
                "link `{link}` follows `{before}` in a module, but its parent is `{parent}`; \
                 a module is a serial chain, listed from its parent outwards"
            ),
            Self::BranchInside { at, leaving } => write!(
                f,
                "the tree branches at link `{at}` (towards `{leaving}`), so a module must end there: \
                 modules leave the last link of their parent module"
            ),
            Self::Empty => write!(f, "the module list contains an empty module; remove it"),
        }
    }
}

impl core::error::Error for ModuleError {}

impl ModuleTree {
    /// Returns the default partition: maximal serial chains.
    #[must_use]
    pub fn chains(model: &Model) -> Self {
        let children = model.children();
        let starts = model.moving_links().iter().enumerate().filter_map(|(i, link)| {
            let continues = link.parent.is_some_and(|parent| children[parent].len() == 1);
            (!continues).then_some(i)
        });
        Self::from_starts(model, starts.collect())
    }

    /// Returns the partition into modules of one link each.
    #[must_use]
    pub fn links(model: &Model) -> Self {
        Self::from_starts(model, (0..model.moving_links().len()).collect())
    }

    /// Returns the modules of a list of link names. Each module lists its links from the parent to
    /// the tip; modules may be in any order.
    ///
    /// # Errors
    ///
    /// Returns every reason why the list is not a partition into chains.
    pub fn from_names<T: AsRef<str>>(
        model: &Model,
        list: &[Vec<T>],
    ) -> Result<Self, Vec<ModuleError>> {
        let links = model.moving_links();
        let name = |i: usize| links[i].name.clone();
        let mut errors = Vec::new();
        let mut seen = alloc::vec![false; links.len()];
        let mut starts = Vec::new();
        let children = model.children();
        let numbers: BTreeMap<&str, usize> =
            links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
        for module in list {
            let mut before = None;
            if module.is_empty() {
                errors.push(ModuleError::Empty);
            }
            for wanted in module {
                let wanted = wanted.as_ref();
                let Some(&i) = numbers.get(wanted) else {
                    let links = links.iter().take(SHOWN).map(|link| link.name.clone()).collect();
                    errors.push(ModuleError::UnknownLink { name: wanted.into(), links });
                    continue;
                };
                if core::mem::replace(&mut seen[i], true) {
                    errors.push(ModuleError::Twice(name(i)));
                    continue;
                }
                match before {
                    None => starts.push(i),
                    Some(b) if links[i].parent != Some(b) => {
                        let parent = links[i].parent.map_or_else(|| "the base".into(), name);
                        errors.push(ModuleError::NotSerial {
                            before: name(b),
                            link: name(i),
                            parent,
                        });
                    }
                    Some(b) => {
                        if let Some(&other) = children[b].iter().find(|&&c| c != i) {
                            errors.push(ModuleError::BranchInside {
                                at: name(b),
                                leaving: name(other),
                            });
                        }
                    }
                }
                before = Some(i);
            }
        }
        errors
            .extend((0..links.len()).filter(|&i| !seen[i]).map(|i| ModuleError::Missing(name(i))));
        if errors.is_empty() {
            starts.sort_unstable();
            Ok(Self::from_starts(model, starts))
        } else {
            Err(errors)
        }
    }

    /// Returns whether the modules are a partition of all links of `model` into chains.
    #[must_use]
    pub fn fits(&self, model: &Model) -> bool {
        let links = model.moving_links();
        let mut next = 0;
        for module in &self.modules {
            let parent = module.parent.and_then(|p| self.modules[p].links.end.checked_sub(1));
            let Range { start, end } = module.links.clone();
            let chain = start == next
                && end <= links.len()
                && links[start..end].iter().enumerate().all(|(k, link)| {
                    link.parent == if k == 0 { parent } else { Some(start + k - 1) }
                });
            if !chain {
                return false;
            }
            next = end;
        }
        next == links.len()
    }

    /// Returns the modules, parents before children.
    #[must_use]
    pub fn modules(&self) -> &[Module] {
        &self.modules
    }

    /// Returns the modules that start at these links, which are ascending.
    fn from_starts(model: &Model, starts: Vec<usize>) -> Self {
        let links = model.moving_links();
        let mut module_of = alloc::vec![0; links.len()];
        let mut modules: Vec<Module> = Vec::with_capacity(starts.len());
        for (m, &start) in starts.iter().enumerate() {
            let end = starts.get(m + 1).copied().unwrap_or(links.len());
            module_of[start..end].fill(m);
            let parent = links[start].parent.map(|link| module_of[link]);
            if let Some(parent) = parent {
                modules[parent].children.push(m);
            }
            modules.push(Module { links: start..end, parent, children: Vec::new() });
        }
        Self { modules }
    }
}
