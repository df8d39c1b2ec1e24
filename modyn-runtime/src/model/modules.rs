//! The kinematic module tree of the paper (Sect. 2).
//!
//! A kinematic module is a chain of serially connected links that leaves the last link of its
//! parent module. In depth-first order its links are consecutive.

use alloc::{collections::BTreeMap, string::String, vec::Vec};
use core::{fmt, ops::Range};

use super::Model;

/// A kinematic module: links in a row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Module {
    /// Its links, from the one next to the parent module to the tip.
    pub links: Range<usize>,
    /// The module whose last link it leaves; `None` for the world.
    pub parent: Option<usize>,
    /// The modules that leave its last link.
    pub children: Vec<usize>,
}

/// A partition of a model's links into kinematic modules, parents before children.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleTree {
    modules: Vec<Module>,
}

/// Why a list of modules is not a partition into chains.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ModuleError {
    /// The name is that of no moving link.
    UnknownLink {
        /// The name in the list.
        name: String,
        /// The names of the first moving links.
        links: Vec<String>,
    },
    /// The link stands in the list twice.
    Twice(String),
    /// The link stands in no module.
    Missing(String),
    /// The second link does not hang on the first, which stands before it in a module.
    NotSerial {
        /// The link that stands before.
        before: String,
        /// The link that does not hang on it.
        link: String,
        /// What it hangs on.
        parent: String,
    },
    /// A module's chain goes on behind a link at which another module leaves.
    BranchInside {
        /// The link inside the module at which the tree branches.
        at: String,
        /// The link of the other module that leaves there.
        leaving: String,
    },
    /// A module without a link.
    Empty,
}

/// How many names a message lists.
const SHOWN: usize = 40;

impl fmt::Display for ModuleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownLink { name, links } => {
                write!(
                    f,
                    "`{name}` in the module list is no moving link; there are: {}{}",
                    links.join(", "),
                    if links.len() < SHOWN { "" } else { ", ..." }
                )
            }
            Self::Twice(link) => {
                write!(
                    f,
                    "link `{link}` stands in the module list twice; each link belongs to one module"
                )
            }
            Self::Missing(link) => {
                write!(f, "link `{link}` stands in no module; the list must hold every moving link")
            }
            Self::NotSerial { before, link, parent } => write!(
                f,
                "link `{link}` follows `{before}` in a module but hangs on `{parent}`; \
                 a module is a serial chain, listed from its parent outwards"
            ),
            Self::BranchInside { at, leaving } => write!(
                f,
                "the tree branches at link `{at}` (towards `{leaving}`), so a module must end there: \
                 modules leave the last link of their parent module"
            ),
            Self::Empty => write!(f, "the module list holds an empty module; remove it"),
        }
    }
}

impl core::error::Error for ModuleError {}

impl ModuleTree {
    /// The default: maximal serial chains.
    #[must_use]
    pub fn chains(model: &Model) -> Self {
        let children = model.children();
        let starts = model.links().iter().enumerate().filter_map(|(i, link)| {
            let continues = link.parent.is_some_and(|parent| children[parent].len() == 1);
            (!continues).then_some(i)
        });
        Self::from_starts(model, starts.collect())
    }

    /// Every link a module: the link-level special case.
    #[must_use]
    pub fn links(model: &Model) -> Self {
        Self::from_starts(model, (0..model.links().len()).collect())
    }

    /// The modules of a list of link names, each from its parent outwards, in any order.
    ///
    /// # Errors
    ///
    /// Every reason why the list is not a partition into chains.
    pub fn from_names<T: AsRef<str>>(
        model: &Model,
        list: &[Vec<T>],
    ) -> Result<Self, Vec<ModuleError>> {
        let links = model.links();
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

    /// Whether these are modules of `model`: its links, all of them, in chains.
    #[must_use]
    pub fn fits(&self, model: &Model) -> bool {
        let links = model.links();
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

    /// The modules, parents before children.
    #[must_use]
    pub fn modules(&self) -> &[Module] {
        &self.modules
    }

    /// The first links of the modules, ascending.
    fn from_starts(model: &Model, starts: Vec<usize>) -> Self {
        let links = model.links();
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
