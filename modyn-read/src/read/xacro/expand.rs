//! Expands the elements of xacro: properties, macros, conditions, includes and blocks.
//!
//! The order is the order of the reference: elements are expanded in the order of the text, a macro
//! sees the properties of its caller, and the block of a caller is expanded once where it is
//! written and once where it is inserted.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use roxmltree::Document;

use super::scopes::{Macro, Parameter, Property, Scopes};
use super::tree::{self, Attribute, Call, Element, MAX_DEPTH, Node, Place};
use super::value::{MAX_WORK, ScopeId, Value};
use crate::description::ReadOptions;
use crate::diagnostics::{Code, Diagnostic, ExpansionCall, Origin, Report, Severity, suggest};
use crate::read::file::read_named;
use crate::read::packages::Packages;
use crate::read::xml;
use crate::work;

/// The largest depth of macro calls and includes.
const MAX_CALLS: usize = 60;
/// The largest number of included files.
const MAX_FILES: usize = 1000;
/// The largest number of properties that are evaluated for each other.
const MAX_PROPERTIES: usize = 100;

/// The largest depth of operations in each other, through all properties: a sum of 500 terms, which
/// is the longest expression, is as deep.
const MAX_OPERATIONS: usize = 600;

/// The reason of a fault if an expansion does too much work.
pub const TOO_LONG: &str =
    "the expansion of the file takes too long: more than a million operations";

/// The reason why an expansion ended; it is in the report.
pub struct Refused;

/// A fault without a place: the reason in words, and advice.
#[derive(Debug)]
pub struct Fault {
    pub reason: String,
    pub help: Option<String>,
}

impl From<String> for Fault {
    fn from(reason: String) -> Self {
        Self { reason, help: None }
    }
}

impl From<&str> for Fault {
    fn from(reason: &str) -> Self {
        String::from(reason).into()
    }
}

impl Fault {
    pub fn with_help(reason: impl Into<String>, help: impl Into<String>) -> Self {
        Self { reason: reason.into(), help: Some(help.into()) }
    }
}

/// The expansion of a file.
pub struct Expander<'e, 'r> {
    pub options: &'e ReadOptions,
    pub report: &'e mut Report<'r>,
    pub scopes: Scopes,
    /// The values of `xacro:arg`.
    pub arguments: BTreeMap<Rc<str>, Rc<str>>,
    /// The files that are being read, the innermost last: the path from the folder of the
    /// description.
    pub files: Vec<PathBuf>,
    /// The calls that the text comes from; the first is the file itself.
    pub calls: Vec<ExpansionCall>,
    /// The declarations of namespaces of all files.
    pub namespaces: BTreeMap<Rc<str>, Rc<str>>,
    /// The place that is being expanded.
    pub place: Place,
    included: usize,
    open_calls: usize,
    depth: usize,
    /// The number of properties that are being evaluated.
    open_properties: usize,
    /// The number of operations that are being evaluated.
    open_operations: usize,
    work: Cell<usize>,
    packages: RefCell<Packages>,
}

/// The element that is being written.
struct Output<'o> {
    attributes: &'o mut Vec<Attribute>,
    children: &'o mut Vec<Node>,
}

type Expanded<T = ()> = Result<T, Refused>;

impl<'e, 'r> Expander<'e, 'r> {
    pub fn new(file: PathBuf, options: &'e ReadOptions, report: &'e mut Report<'r>) -> Self {
        let given = options.xacro_args.iter();
        let arguments =
            given.map(|argument| (argument.name.as_str().into(), argument.value.as_str().into()));
        Self {
            options,
            arguments: arguments.collect(),
            files: vec![file],
            report,
            scopes: Scopes::new(),
            calls: vec![ExpansionCall::default()],
            namespaces: BTreeMap::new(),
            place: Place { at: 0, call: Some(0) },
            included: 0,
            open_calls: 0,
            depth: 0,
            open_properties: 0,
            open_operations: 0,
            work: Cell::new(0),
            packages: RefCell::default(),
        }
    }

    /// Returns the expanded document.
    pub fn document(&mut self, root: &Element) -> Expanded<Element> {
        self.declare(root);
        self.element(root, Scopes::FILE, 0)
    }

    /// Counts work; an error if there is too much.
    pub fn spend(&self, amount: usize) -> Result<(), String> {
        work::count(amount);
        self.work.set(self.work.get().saturating_add(amount));
        if self.work.get() > MAX_WORK {
            return Err(TOO_LONG.into());
        }
        Ok(())
    }

    /// Reports a fault at a place.
    fn refuse<T>(&mut self, place: Place, fault: impl Into<Fault>) -> Expanded<T> {
        let Fault { reason, help } = fault.into();
        let help = help.unwrap_or_else(|| {
            let help = if reason.ends_with(TOO_LONG) {
                "make loops, recursions, repeated values and aliases of YAML shorter, or expand the \
                 file by `xacro` and read the URDF"
            } else {
                "the language is that of `xacro` 2; docs/command.md says what modyn reads of it"
            };
            help.into()
        });
        let error = Diagnostic::new(Severity::Error, Code::Xacro, reason).with_help(help);
        let call = place.call.unwrap_or(0);
        self.report.add_in_call(error, &Origin { at: place.at, calls: &self.calls, call });
        Err(Refused)
    }

    fn at<T>(&mut self, place: Place, result: Result<T, impl Into<Fault>>) -> Expanded<T> {
        result.or_else(|fault| self.refuse(place, fault))
    }

    /// Returns the tree of a document whose text starts at offset `start` of the report.
    /// The call is the call of the include.
    pub fn tree(&mut self, document: &Document<'_>, start: usize, call: Call) -> Expanded<Element> {
        let tree = tree::of_document(document, start);
        tree.or_else(|at| self.refuse_depth(Place { at, call: Some(call) }))
    }

    /// Enters an element, a condition or a block; an error if there are too many of them around it.
    fn deeper(&mut self, place: Place) -> Expanded {
        self.depth += 1;
        if self.depth > MAX_DEPTH { self.refuse_depth(place) } else { Ok(()) }
    }

    fn refuse_depth<T>(&mut self, place: Place) -> Expanded<T> {
        let reason = format!("elements are nested more than {MAX_DEPTH} deep");
        let help = "write the links and joints beside each other, directly in `<robot>`; if a macro \
                    calls itself, end the recursion by a condition";
        self.refuse(place, Fault::with_help(reason, help))
    }

    /// Enters an operation of an expression; an error if there are too many of them around it.
    pub fn enter(&mut self) -> Result<(), String> {
        self.open_operations += 1;
        if self.open_operations > MAX_OPERATIONS {
            return Err(format!(
                "operations are nested more than {MAX_OPERATIONS} deep, with those of properties: \
                 evaluate some properties where they are defined, by `lazy_eval=\"false\"`"
            ));
        }
        Ok(())
    }

    /// Leaves an operation of an expression.
    pub fn leave(&mut self) {
        self.open_operations -= 1;
    }

    /// Remembers the namespaces that a document declares.
    fn declare(&mut self, root: &Element) {
        for attribute in &root.attributes {
            if attribute.name.starts_with("xmlns") && &*attribute.name != "xmlns:xacro" {
                self.namespaces.entry(attribute.name.clone()).or_insert(attribute.value.clone());
            }
        }
    }

    /// Returns an element with its attributes and children expanded.
    fn element(&mut self, element: &Element, scope: ScopeId, call: Call) -> Expanded<Element> {
        let place = element.place.expanded_by(call);
        self.deeper(place)?;
        let work = self.spend(1 + element.attributes.len());
        self.at(place, work)?;
        let mut attributes = Vec::with_capacity(element.attributes.len());
        for attribute in &element.attributes {
            if attribute.name.starts_with("xacro:") || attribute.name.starts_with("xmlns") {
                continue;
            }
            let place = attribute.place.expanded_by(call);
            let value = self.evaluated_text(&attribute.value, place, scope)?;
            attributes.push(Attribute { name: attribute.name.clone(), value, place });
        }
        let mut children = Vec::with_capacity(element.children.len());
        let mut output = Output { attributes: &mut attributes, children: &mut children };
        self.children(element, scope, call, &mut output)?;
        self.depth -= 1;
        Ok(Element { name: element.name.clone(), place, attributes, children })
    }

    /// Expands the children of an element.
    fn children(
        &mut self,
        element: &Element,
        scope: ScopeId,
        call: Call,
        output: &mut Output<'_>,
    ) -> Expanded {
        for child in &element.children {
            match child {
                Node::Text(text, place) => {
                    let place = place.expanded_by(call);
                    let text = self.evaluated_text(text, place, scope)?;
                    output.children.push(Node::Text(text, place));
                }
                Node::Element(child) => self.child(child, scope, call, output)?,
            }
        }
        Ok(())
    }

    fn child(
        &mut self,
        element: &Rc<Element>,
        scope: ScopeId,
        call: Call,
        output: &mut Output<'_>,
    ) -> Expanded {
        let place = element.place.expanded_by(call);
        self.place = place;
        let Some(name) = element.xacro_name() else {
            let expanded = self.element(element, scope, call)?;
            output.children.push(Node::Element(Rc::new(expanded)));
            return Ok(());
        };
        let work = self.spend(1);
        self.at(place, work)?;
        match name {
            "property" => self.property(element, scope, call),
            "macro" => self.define(element, scope, call),
            "arg" => self.argument(element, scope, call),
            "include" => self.include(element, scope, call, output),
            "insert_block" => self.insert_block(element, scope, call, output),
            "if" | "unless" => {
                let value = self.required(element, "value", call)?;
                let condition = self.evaluated(&value.value, value.place, scope)?;
                let holds = self.at(value.place, truth(&condition, &value.value))?;
                if holds == (name == "if") {
                    // As in the reference, `xacro:attribute` in a condition changes nothing.
                    let mut unused = Vec::new();
                    let children = &mut *output.children;
                    let mut output = Output { attributes: &mut unused, children };
                    self.deeper(place)?;
                    self.children(element, scope, call, &mut output)?;
                    self.depth -= 1;
                }
                Ok(())
            }
            "element" => {
                let name = self.required(element, "xacro:name", call)?;
                let tag = self.evaluated_text(&name.value, name.place, scope)?;
                if !is_xml_name(&tag) {
                    return self.refuse(name.place, format!("`{tag}` is not a name of an element"));
                }
                let mut renamed = Element { name: tag, ..(**element).clone() };
                renamed.attributes.retain(|attribute| &*attribute.name != "xacro:name");
                self.again(renamed, scope, call, output)
            }
            "attribute" => {
                let name = self.required(element, "name", call)?;
                let value = self.required(element, "value", call)?;
                let attribute_name = self.evaluated_text(&name.value, name.place, scope)?;
                if !is_xml_name(&attribute_name) {
                    return self.refuse(
                        name.place,
                        format!("`{attribute_name}` is not a name of an attribute"),
                    );
                }
                let text = self.evaluated_text(&value.value, value.place, scope)?;
                output.attributes.retain(|attribute| attribute.name != attribute_name);
                output.attributes.push(Attribute { name: attribute_name, value: text, place });
                Ok(())
            }
            "call" => {
                let name = self.required(element, "macro", call)?;
                let macro_name = self.evaluated_text(&name.value, name.place, scope)?;
                let mut renamed =
                    Element { name: format!("xacro:{macro_name}").into(), ..(**element).clone() };
                renamed.attributes.retain(|attribute| &*attribute.name != "macro");
                self.again(renamed, scope, call, output)
            }
            name => self.call(element, name, scope, call, output),
        }
    }

    /// Expands an element under its evaluated name, which can be the name of a macro, or of an
    /// element of xacro.
    fn again(
        &mut self,
        renamed: Element,
        scope: ScopeId,
        call: Call,
        output: &mut Output<'_>,
    ) -> Expanded {
        self.deeper(renamed.place.expanded_by(call))?;
        self.child(&Rc::new(renamed), scope, call, output)?;
        self.depth -= 1;
        Ok(())
    }

    /// Returns an attribute that must be there.
    fn required(&mut self, element: &Element, name: &str, call: Call) -> Expanded<Attribute> {
        match element.attribute(name) {
            Some(attribute) => {
                let place = attribute.place.expanded_by(call);
                Ok(Attribute { place, ..attribute.clone() })
            }
            None => {
                let reason = format!("the attribute `{name}` of `<{}>` is missing", element.name);
                let help = format!("write `<{} {name}=\"...\">`", element.name);
                self.refuse(element.place.expanded_by(call), Fault::with_help(reason, help))
            }
        }
    }

    /// Returns the value of a text at a place.
    fn evaluated(&mut self, text: &str, place: Place, scope: ScopeId) -> Expanded<Value> {
        // Most texts have nothing to evaluate.
        if !text.contains('$') {
            return Ok(Value::text(text));
        }
        self.place = place;
        let value = self.text(text, scope);
        self.at(place, value)
    }

    /// Returns the value of a text at a place, as text.
    fn evaluated_text(&mut self, text: &str, place: Place, scope: ScopeId) -> Expanded<Rc<str>> {
        let value = self.evaluated(text, place, scope)?;
        self.at(place, value.display().map_err(Fault::from))
    }

    fn property(&mut self, element: &Rc<Element>, scope: ScopeId, call: Call) -> Expanded {
        let place = element.place.expanded_by(call);
        let name_attribute = self.required(element, "name", call)?;
        let name = self.evaluated_text(&name_attribute.value, name_attribute.place, scope)?;
        if !is_identifier(&name) || name.starts_with("__") {
            let reason = format!("`{name}` is not a name of a property");
            let help = "write letters, digits and underscores, and no word of the language";
            return self.refuse(place, Fault::with_help(reason, help));
        }
        let flag = |expander: &mut Self, name: &str, default: bool| match element.attribute(name) {
            None => Ok(default),
            Some(attribute) => {
                let place = attribute.place.expanded_by(call);
                let value = expander.evaluated(&attribute.value, place, scope)?;
                expander.at(place, truth(&value, &attribute.value))
            }
        };
        let remove = flag(self, "remove", false)?;
        let mut is_lazy = flag(self, "lazy_eval", true)?;
        let [value, default, wanted] =
            ["value", "default", "scope"].map(|name| element.attribute(name).cloned());
        if usize::from(value.is_some()) + usize::from(default.is_some()) + usize::from(remove) > 1 {
            let reason = "`value`, `default` and `remove` of a property exclude each other";
            return self.refuse(place, reason);
        }
        if remove {
            self.scopes.remove(scope, &name);
            return Ok(());
        }
        if default.is_some() && self.scopes.holder(scope, &name).is_some() {
            return Ok(());
        }
        let target = match wanted.as_ref().map(|wanted| &*wanted.value) {
            Some("global") => {
                is_lazy = false;
                Scopes::FILE
            }
            Some("parent") => {
                is_lazy = false;
                let Some(parent) = self.scopes.parent(scope) else {
                    let reason =
                        "there is no scope around this one: the property is not in a macro";
                    return self.refuse(place, reason);
                };
                parent
            }
            _ => scope,
        };
        let Some(value) = value.or(default) else {
            let block = Property::Value(Value::Block(element.clone()));
            self.scopes.set(target, format!("**{name}").into(), block);
            return Ok(());
        };
        let property = if is_lazy {
            match literal(&value.value) {
                Value::Text(text) => Property::Lazy(text),
                other => Property::Value(other),
            }
        } else {
            let value = self.evaluated(&value.value, value.place.expanded_by(call), scope)?;
            Property::Value(match value {
                Value::Text(text) => literal(&text),
                other => other,
            })
        };
        self.scopes.set(target, name, property);
        Ok(())
    }

    fn define(&mut self, element: &Rc<Element>, scope: ScopeId, call: Call) -> Expanded {
        let name = self.required(element, "name", call)?;
        let plain: Rc<str> = name.value.strip_prefix("xacro:").unwrap_or(&name.value).into();
        if &*plain == "call" || plain.contains('.') || !is_xml_name(&plain) {
            let reason = format!("`{plain}` is not a name of a macro");
            return self.refuse(name.place, reason);
        }
        let mut parameters = Vec::new();
        let mut rest = element.attribute("params").map_or("", |attribute| &attribute.value);
        while !rest.trim().is_empty() {
            let (parameter, after) = parameter(rest);
            parameters.push(parameter);
            rest = after;
        }
        self.scopes.define(scope, plain, Macro { element: element.clone(), parameters });
        Ok(())
    }

    fn argument(&mut self, element: &Element, scope: ScopeId, call: Call) -> Expanded {
        let name = self.required(element, "name", call)?;
        let default = self.required(element, "default", call)?;
        if !self.arguments.contains_key(&name.value) {
            let value = self.evaluated_text(&default.value, default.place, scope)?;
            self.arguments.insert(name.value, value);
        }
        Ok(())
    }

    fn include(
        &mut self,
        element: &Element,
        scope: ScopeId,
        call: Call,
        output: &mut Output<'_>,
    ) -> Expanded {
        let place = element.place.expanded_by(call);
        let name = self.required(element, "filename", call)?;
        let file = self.evaluated_text(&name.value, name.place, scope)?;
        let path = self.beside(&file);
        let optional = match element.attribute("optional") {
            Some(attribute) => {
                let is_optional = truth(&Value::Text(attribute.value.clone()), &attribute.value);
                self.at(place, is_optional)?
            }
            None => false,
        };
        if file.contains(['*', '?', '[']) {
            let help = "write an `<xacro:include>` for each file";
            let reason = "patterns of several files are not read";
            return self.refuse(name.place, Fault::with_help(reason, help));
        }
        if optional && !self.options.files.is_file(&self.absolute(&path)) {
            return Ok(());
        }
        let inner = match element.attribute("ns") {
            Some(namespace) => {
                let namespace_name = self.evaluated_text(&namespace.value, place, scope)?;
                self.scopes.add_namespace(scope, namespace_name)
            }
            None => scope,
        };
        self.included += 1;
        if self.included > MAX_FILES {
            return self.refuse(place, format!("more than {MAX_FILES} files are included"));
        }
        let Some((text, start)) = self.read(&path, name.place) else { return Err(Refused) };
        let Some(text) = xml::document::within_limits(&text, start, self.report) else {
            return Err(Refused);
        };
        let document = xml::document::parse(&text, start, "robot", self.report).ok_or(Refused)?;
        let call_of_file = self.open_call(String::from("include"), place)?;
        let root = self.tree(&document, start, call_of_file)?;
        self.declare(&root);
        self.files.push(path);
        // The attributes of the outermost element are dropped, `xacro:attribute` beside its
        // children too.
        let children = &mut *output.children;
        let mut output = Output { attributes: &mut Vec::new(), children };
        self.children(&root, inner, call_of_file, &mut output)?;
        self.files.pop();
        self.open_calls -= 1;
        Ok(())
    }

    /// Returns the text of a file that the description names, and its start in the report.
    fn read(&mut self, path: &Path, place: Place) -> Option<(String, usize)> {
        if self.options.folder.is_none() && path.is_relative() {
            let help = "read the file by its path; a text alone has no folder";
            let reason = "another file is included, but the description is a text without a folder";
            let _ = self.refuse::<()>(place, Fault::with_help(reason, help));
            return None;
        }
        let absolute = self.absolute(path);
        // Relative as the name of the description is.
        let folder = self.report.file_name(0).map(Path::new).and_then(Path::parent);
        let shown = folder.unwrap_or(Path::new("")).join(path).display().to_string();
        read_named(&self.options.files, &absolute, &shown, place.at, self.report)
    }

    /// Returns the text of a file for an expression.
    pub fn read_text(&mut self, path: &Path) -> Result<String, Fault> {
        self.included += 1;
        if self.included > MAX_FILES {
            return Err(format!("more than {MAX_FILES} files are read").into());
        }
        let before = self.report.errors();
        let text = self.read(path, self.place).map(|(text, _)| text);
        match text {
            Some(text) => Ok(text),
            None if self.report.errors() > before => Err("the file could not be read".into()),
            None => Err("a file could not be read".into()),
        }
    }

    fn absolute(&self, path: &Path) -> PathBuf {
        self.options.folder.as_deref().unwrap_or(Path::new("")).join(path)
    }

    /// Returns the path of a file that the current file names, from the folder of the description.
    pub fn beside(&self, file: &str) -> PathBuf {
        let folder = self.files.last().and_then(|file| file.parent());
        folder.unwrap_or(Path::new("")).join(file)
    }

    /// Returns the folder of a package.
    pub fn package(&self, name: &str) -> Result<String, Fault> {
        let package = self.packages.borrow_mut().find(name, self.options);
        package.map(|folder| folder.display().to_string()).ok_or_else(|| {
            Fault::with_help(
                format!("the package `{name}` was not found"),
                format!("name its folder by the option `packages = [\"{name}\": \"folder\"]`, or set ROS_PACKAGE_PATH"),
            )
        })
    }

    /// Adds a call of a macro or an include at a place.
    fn open_call(&mut self, name: String, place: Place) -> Expanded<Call> {
        self.open_calls += 1;
        if self.open_calls > MAX_CALLS {
            let reason = format!("macros and includes call each other more than {MAX_CALLS} deep");
            let help = "end the recursion by a condition";
            return self.refuse(place, Fault::with_help(reason, help));
        }
        self.calls.push(ExpansionCall { name, at: place.at, parent: place.call.unwrap_or(0) });
        Ok(self.calls.len() - 1)
    }

    fn insert_block(
        &mut self,
        element: &Element,
        scope: ScopeId,
        call: Call,
        output: &mut Output<'_>,
    ) -> Expanded {
        let name = self.required(element, "name", call)?;
        let property = ["**", "*"].into_iter().find_map(|stars| {
            let name = format!("{stars}{}", name.value);
            let holder = self.scopes.holder(scope, &name)?;
            match self.scopes.property(holder, &name)? {
                Property::Value(Value::Block(block)) => Some((block.clone(), stars == "**")),
                _ => None,
            }
        });
        let Some((block, only_content)) = property else {
            return self.refuse(name.place, format!("there is no block `{}`", name.value));
        };
        self.deeper(name.place)?;
        if only_content {
            let mut unused = Vec::new();
            let children = &mut *output.children;
            let mut output = Output { attributes: &mut unused, children };
            self.children(&block, scope, call, &mut output)?;
        } else {
            let expanded = self.element(&block, scope, call)?;
            output.children.push(Node::Element(Rc::new(expanded)));
        }
        self.depth -= 1;
        Ok(())
    }

    fn call(
        &mut self,
        element: &Element,
        name: &str,
        scope: ScopeId,
        call: Call,
        output: &mut Output<'_>,
    ) -> Expanded {
        let place = element.place.expanded_by(call);
        let Some((definition, called)) = self.scopes.find_macro(scope, name) else {
            let names: Vec<String> = self.scopes.macro_names(scope).map(Into::into).collect();
            let help = match suggest(name, names.iter().map(String::as_str)) {
                Some(meant) => format!("did you mean `xacro:{meant}`?"),
                None => "define it before its call, or include the file that defines it".into(),
            };
            let reason = format!("there is no macro `{name}`");
            return self.refuse(place, Fault::with_help(reason, help));
        };
        // The arguments belong to the caller.
        let mut given: Vec<(Rc<str>, Property)> = Vec::new();
        for attribute in
            element.attributes.iter().filter(|attribute| !attribute.name.starts_with("xmlns"))
        {
            let place = attribute.place.expanded_by(call);
            let names = || called.parameters.iter().map(|parameter| &*parameter.name);
            if !names().any(|parameter| *parameter == *attribute.name) {
                let help = match suggest(&attribute.name, names()) {
                    Some(meant) => format!("did you mean `{meant}`?"),
                    None => {
                        format!("its parameters are: {}", names().collect::<Vec<_>>().join(" "))
                    }
                };
                let reason = format!("the macro `{name}` has no parameter `{}`", attribute.name);
                return self.refuse(place, Fault::with_help(reason, help));
            }
            let value = self.evaluated(&attribute.value, place, scope)?;
            given.push((attribute.name.clone(), argument(value)));
        }
        // Blocks are expanded where they are written.
        let mut blocks = Vec::new();
        let mut unused = Vec::new();
        self.children(
            element,
            scope,
            call,
            &mut Output { attributes: &mut unused, children: &mut blocks },
        )?;
        let mut blocks = blocks.into_iter().filter_map(|node| match node {
            Node::Element(block) => Some(block),
            Node::Text(..) => None,
        });
        for parameter in
            called.parameters.iter().filter(|parameter| parameter.name.starts_with('*'))
        {
            let Some(block) = blocks.next() else {
                let reason = format!("the macro `{name}` needs the block `{}`", parameter.name);
                return self
                    .refuse(place, Fault::with_help(reason, "write an element inside the call"));
            };
            given.push((parameter.name.clone(), Property::Value(Value::Block(block))));
        }
        if let Some(block) = blocks.next() {
            let reason =
                format!("the macro `{name}` has no parameter for the block `<{}>`", block.name);
            return self.refuse(block.place, reason);
        }
        for parameter in &called.parameters {
            if parameter.name.starts_with('*')
                || given.iter().any(|(argument, _)| *argument == parameter.name)
            {
                continue;
            }
            self.place = place;
            let holder = self.scopes.holder(scope, &parameter.name).filter(|_| parameter.forwards);
            let value = match (holder, &parameter.default) {
                (Some(_), _) => {
                    let value = self.lookup(scope, &parameter.name);
                    self.at(place, value)?.unwrap_or(Value::None)
                }
                (None, Some(default)) => self.evaluated(default, place, scope)?,
                (None, None) if parameter.forwards => {
                    let reason =
                        format!("the caller has no property `{}` to forward", parameter.name);
                    return self.refuse(place, reason);
                }
                (None, None) => {
                    let reason =
                        format!("the macro `{name}` needs the parameter `{}`", parameter.name);
                    let help = format!("write `<xacro:{name} {}=\"...\"/>`", parameter.name);
                    return self.refuse(place, Fault::with_help(reason, help));
                }
            };
            given.push((parameter.name.clone(), argument(value)));
        }
        let inner = self.scopes.enter(definition);
        for (name, property) in given {
            self.scopes.set(inner, name, property);
        }
        let own_call = self.open_call(format!("macro `{name}`"), place)?;
        let body = called.element.clone();
        let children = &mut *output.children;
        let mut output = Output { attributes: &mut Vec::new(), children };
        self.children(&body, inner, own_call, &mut output)?;
        self.open_calls -= 1;
        self.scopes.leave(inner);
        Ok(())
    }

    /// Returns the value of a property, which is evaluated now if it was not yet; `None` if there
    /// is none.
    pub fn lookup(&mut self, scope: ScopeId, name: &str) -> Result<Option<Value>, Fault> {
        let Some(holder) = self.scopes.holder(scope, name) else { return Ok(None) };
        let text = match self.scopes.property(holder, name) {
            Some(Property::Value(value)) => return Ok(Some(value.clone())),
            Some(Property::Lazy(text)) => text.clone(),
            Some(Property::Open) => {
                let reason = format!("the property `{name}` is defined by itself");
                let help = "evaluate it where it is defined: `lazy_eval=\"false\"`";
                return Err(Fault::with_help(reason, help));
            }
            None => return Ok(None),
        };
        self.open_properties += 1;
        if self.open_properties > MAX_PROPERTIES {
            let reason = format!("more than {MAX_PROPERTIES} properties need each other");
            return Err(Fault::with_help(
                reason,
                "evaluate some where they are defined: `lazy_eval=\"false\"`",
            ));
        }
        self.scopes.set(holder, name.into(), Property::Open);
        let value = self.text(&text, holder).map_err(|fault| match fault {
            // The fault is in the innermost property.
            Fault { reason, .. } if reason.starts_with("in the property") => {
                Fault { reason, ..fault }
            }
            Fault { reason, .. } => {
                Fault { reason: format!("in the property `{name}`: {reason}"), ..fault }
            }
        })?;
        self.open_properties -= 1;
        let value = match value {
            Value::Text(text) => literal(&text),
            other => other,
        };
        self.scopes.set(holder, name.into(), Property::Value(value.clone()));
        Ok(Some(value))
    }

    /// Adds a warning at the place that is being expanded.
    pub fn warn(&mut self, message: &str) {
        let help = "the description itself has this warning";
        let warning =
            Diagnostic::new(Severity::Warning, Code::XacroWarning, message).with_help(help);
        let Place { at, call } = self.place;
        let origin = Origin { at, calls: &self.calls, call: call.unwrap_or(0) };
        self.report.add_in_call(warning, &origin);
    }
}

/// Returns the property of an argument: a text is a number if it looks like one.
fn argument(value: Value) -> Property {
    Property::Value(match value {
        Value::Text(text) => literal(&text),
        other => other,
    })
}

/// Returns the value of a text that is a number, a truth value or a text in quotes; else the text
/// itself.
fn literal(text: &str) -> Value {
    use super::functions::{literal_float, literal_int};
    let quoted = text.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\''));
    if let Some(inner) = quoted {
        return Value::text(inner);
    }
    if text.contains('_') {
        return Value::text(text);
    }
    if let Some(value) = literal_int(text) {
        return Value::Int(value);
    }
    if let Some(value) = literal_float(text) {
        return Value::Float(value);
    }
    match text {
        "true" | "True" => Value::Bool(true),
        "false" | "False" => Value::Bool(false),
        _ => Value::text(text),
    }
}

/// Returns the truth value of a condition.
fn truth(value: &Value, text: &str) -> Result<bool, Fault> {
    let Value::Text(word) = value else { return Ok(value.is_true()) };
    match (&**word, super::functions::literal_int(word)) {
        ("true" | "True", _) => Ok(true),
        ("false" | "False", _) => Ok(false),
        (_, Some(value)) => Ok(value != 0),
        _ => Err(Fault::with_help(
            format!("the condition \"{text}\" is \"{word}\", which is neither true nor false"),
            "write `true`, `false`, or an expression: `${name == 'value'}`",
        )),
    }
}

/// Returns whether a text can be a name in an expression.
fn is_identifier(name: &str) -> bool {
    let words = [
        "and", "as", "assert", "async", "await", "break", "class", "continue", "def", "del",
        "elif", "else", "except", "False", "finally", "for", "from", "global", "if", "import",
        "in", "is", "lambda", "None", "nonlocal", "not", "or", "pass", "raise", "return", "True",
        "try", "while", "with", "yield",
    ];
    let mut chars = name.chars();
    chars.next().is_some_and(|c| c.is_alphabetic() || c == '_')
        && chars.all(|c| c.is_alphanumeric() || c == '_')
        && !words.contains(&name)
}

/// Returns whether a text can be the name of an element or an attribute.
fn is_xml_name(name: &str) -> bool {
    let mut chars = name.chars();
    let one_prefix =
        name.matches(':').count() <= 1 && !name.starts_with(':') && !name.ends_with(':');
    one_prefix
        && chars.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && chars.all(|c| c.is_ascii_alphanumeric() || "_:-.".contains(c))
}

/// Returns the first parameter of a list, and the rest.
fn parameter(text: &str) -> (Parameter, &str) {
    let text = text.trim_start();
    with_default(text).unwrap_or_else(|| {
        let end = text.find(char::is_whitespace).unwrap_or(text.len());
        let (name, rest) = text.split_at(end);
        (Parameter { name: name.into(), forwards: false, default: None }, rest)
    })
}

/// Returns a parameter with a default: `name:=default`, `name:=^` or `name:=^|default`.
fn with_default(text: &str) -> Option<(Parameter, &str)> {
    let end = text.find(|c: char| c.is_whitespace() || ":=".contains(c))?;
    let (name, rest) = text.split_at(end);
    let trimmed = rest.trim_start();
    let rest = trimmed.strip_prefix(":=").or_else(|| trimmed.strip_prefix('='))?.trim_start();
    let forwarded = rest.strip_prefix('^');
    let rest = forwarded.map_or(rest, |rest| rest.strip_prefix('|').unwrap_or(rest));
    let ends = |at: usize| rest[at..].is_empty() || rest[at..].starts_with(char::is_whitespace);
    let closed = |open: &str, close: char| {
        let mut places =
            rest.starts_with(open).then(|| rest.match_indices(close)).into_iter().flatten();
        places.find(|(at, _)| ends(at + 1)).map(|(at, _)| at + 1)
    };
    let end = closed("${", '}').or_else(|| closed("$(", ')')).or_else(|| quoted_end(rest))?;
    let (default, after) = rest.split_at(end);
    let default = (!default.is_empty()).then(|| default.into());
    Some((Parameter { name: name.into(), forwards: forwarded.is_some(), default }, after))
}

/// Returns the end of a default: of words and texts in quotes without spaces between them.
fn quoted_end(text: &str) -> Option<usize> {
    let mut quote = None;
    for (at, c) in text.char_indices() {
        match quote {
            Some(open) if c == open => quote = None,
            Some(_) => {}
            None if c.is_whitespace() => return Some(at),
            None if c == '\'' || c == '"' => quote = Some(c),
            None => {}
        }
    }
    quote.is_none().then_some(text.len())
}
