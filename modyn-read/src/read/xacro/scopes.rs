//! Scopes: the properties and macros that are visible at a place.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::tree::Element;
use super::value::{ScopeId, Value};

/// A property.
#[derive(Clone, Debug)]
pub enum Property {
    Value(Value),
    /// A text that is evaluated at its first use.
    Lazy(Rc<str>),
    /// A text that is being evaluated.
    Open,
}

/// A macro.
#[derive(Debug)]
pub struct Macro {
    pub element: Rc<Element>,
    pub parameters: Vec<Parameter>,
}

/// A parameter of a macro.
#[derive(Debug)]
pub struct Parameter {
    /// The name; the name of a block begins with `*`.
    pub name: Rc<str>,
    /// Whether the caller's property of this name is the default.
    pub forwards: bool,
    /// The default, a text to be evaluated.
    pub default: Option<Rc<str>>,
}

/// The properties of the file, of a namespace, or of a macro call.
#[derive(Default)]
struct Scope {
    parent: Option<ScopeId>,
    is_namespace: bool,
    properties: BTreeMap<Rc<str>, Property>,
    macros: BTreeMap<Rc<str>, Rc<Macro>>,
    /// The included files with a namespace.
    namespaces: BTreeMap<Rc<str>, ScopeId>,
}

/// All scopes. Properties are found in the scope of the caller, macros in the scope of their
/// definition or its callers.
pub struct Scopes(Vec<Scope>);

impl Scopes {
    /// The scope of the file.
    pub const FILE: ScopeId = ScopeId(0);

    pub fn new() -> Self {
        Self(vec![Scope::default()])
    }

    /// Adds a scope of a macro call inside another one.
    pub fn enter(&mut self, parent: ScopeId) -> ScopeId {
        self.0.push(Scope { parent: Some(parent), ..Scope::default() });
        ScopeId(self.0.len() - 1)
    }

    /// Ends the newest scope, if it has no namespaces that others may refer to.
    pub fn leave(&mut self, scope: ScopeId) {
        if scope.0 + 1 == self.0.len() {
            self.0.pop();
        }
    }

    /// Adds a scope for the file that is included with a namespace.
    pub fn add_namespace(&mut self, parent: ScopeId, name: Rc<str>) -> ScopeId {
        let id = self.enter(parent);
        self.0[id.0].is_namespace = true;
        self.0[parent.0].namespaces.insert(name, id);
        id
    }

    /// Returns a scope and all scopes around it.
    fn around(&self, scope: ScopeId) -> impl Iterator<Item = ScopeId> {
        std::iter::successors(Some(scope), |scope| self.0[scope.0].parent)
    }

    /// Returns the scope with a property of this name.
    pub fn holder(&self, scope: ScopeId, name: &str) -> Option<ScopeId> {
        self.around(scope).find(|scope| self.0[scope.0].properties.contains_key(name))
    }

    /// Returns a property of exactly this scope.
    pub fn property(&self, scope: ScopeId, name: &str) -> Option<&Property> {
        self.0[scope.0].properties.get(name)
    }

    /// Returns the namespace of this name.
    pub fn namespace(&self, scope: ScopeId, name: &str) -> Option<ScopeId> {
        self.around(scope).find_map(|scope| self.0[scope.0].namespaces.get(name).copied())
    }

    pub fn set(&mut self, scope: ScopeId, name: Rc<str>, property: Property) {
        self.0[scope.0].properties.insert(name, property);
    }

    /// Removes a property from a scope and all scopes around it.
    pub fn remove(&mut self, scope: ScopeId, name: &str) {
        let around: Vec<ScopeId> = self.around(scope).collect();
        for scope in around {
            self.0[scope.0].properties.remove(name);
        }
    }

    /// Returns the scope of properties with `scope="parent"`; `None` in the scope of the file. From
    /// a macro that is the scope of the caller, past namespaces.
    pub fn parent(&self, scope: ScopeId) -> Option<ScopeId> {
        let parent = self.0[scope.0].parent?;
        if self.0[scope.0].is_namespace {
            return Some(parent);
        }
        self.around(parent).find(|scope| !self.0[scope.0].is_namespace)
    }

    pub fn define(&mut self, scope: ScopeId, name: Rc<str>, defined: Macro) {
        self.0[scope.0].macros.insert(name, Rc::new(defined));
    }

    /// Returns a macro by its name, which may begin with namespaces (`hand.finger`), and the scope
    /// that its call is in.
    pub fn find_macro(&self, scope: ScopeId, name: &str) -> Option<(ScopeId, Rc<Macro>)> {
        let macro_in = |scope: ScopeId, name: &str| {
            self.around(scope).find_map(|scope| self.0[scope.0].macros.get(name).cloned())
        };
        if let Some(definition) = macro_in(scope, name) {
            return Some((scope, definition));
        }
        let (namespaces, name) = name.rsplit_once('.')?;
        let mut scope = scope;
        for namespace in namespaces.split('.') {
            scope = self.namespace(scope, namespace)?;
        }
        macro_in(scope, name).map(|definition| (scope, definition))
    }

    /// Returns the names of the macros that can be called.
    pub fn macro_names(&self, scope: ScopeId) -> impl Iterator<Item = &str> {
        self.around(scope).flat_map(|scope| self.0[scope.0].macros.keys().map(|name| &**name))
    }

    /// Returns the names of the properties that are visible.
    pub fn property_names(&self, scope: ScopeId) -> impl Iterator<Item = &str> {
        self.around(scope).flat_map(|scope| self.0[scope.0].properties.keys().map(|name| &**name))
    }
}
