//! The XML of a xacro as a tree, whose nodes keep their places.

use std::rc::Rc;

use roxmltree::Document;

/// A call of a macro or an include, by its number; 0 for text of the main file that no call
/// produced.
pub type Call = usize;

/// A place: the byte offset in the report's files, and the call that led there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    pub at: usize,
    /// The call; `None` in text that was not expanded yet.
    pub call: Option<Call>,
}

impl Place {
    /// Returns the place in text that this call expands. Text that was expanded before, such as a
    /// block, keeps its call.
    pub fn expanded_by(self, call: Call) -> Self {
        Self { call: self.call.or(Some(call)), ..self }
    }
}

/// An element.
#[derive(Clone, Debug)]
pub struct Element {
    /// The name, with the prefix as it is written.
    pub name: Rc<str>,
    pub place: Place,
    pub attributes: Vec<Attribute>,
    pub children: Vec<Node>,
}

/// An attribute.
#[derive(Clone, Debug)]
pub struct Attribute {
    /// The name, with the prefix as it is written.
    pub name: Rc<str>,
    pub value: Rc<str>,
    pub place: Place,
}

/// A child of an element. Comments are not kept: they have no meaning.
#[derive(Clone, Debug)]
pub enum Node {
    Element(Rc<Element>),
    Text(Rc<str>, Place),
}

impl Element {
    /// Returns an attribute by its name.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| &*attribute.name == name)
    }

    /// Returns the name behind `xacro:`; `None` if the element is no element of xacro.
    pub fn xacro_name(&self) -> Option<&str> {
        self.name.strip_prefix("xacro:")
    }
}

/// The largest depth of elements in each other: in a document, and through all macros.
pub const MAX_DEPTH: usize = 150;

/// Returns the outermost element of a document, whose text starts at offset `start` of the report.
/// An error is the offset of an element beyond the largest depth, before any recursion.
pub fn of_document(document: &Document<'_>, start: usize) -> Result<Element, usize> {
    let mut depth = 1;
    let mut node = document.root_element();
    loop {
        if depth > MAX_DEPTH {
            return Err(start + node.range().start);
        }
        if let Some(child) = node.first_element_child() {
            node = child;
            depth += 1;
            continue;
        }
        // The next element after this one and its ancestors that end with it.
        let next = loop {
            if let Some(sibling) = node.next_sibling_element() {
                break sibling;
            }
            match node.parent_element() {
                Some(parent) => node = parent,
                None => return Ok(element(document.root_element(), start)),
            }
            depth -= 1;
        };
        node = next;
    }
}

fn element(node: roxmltree::Node<'_, '_>, start: usize) -> Element {
    let text = node.document().input_text();
    let place = |at: usize| Place { at: start + at, call: None };
    let named = |at: usize| {
        let rest = &text[at..];
        let end = rest.find(|c: char| c.is_whitespace() || "=/>".contains(c));
        Rc::from(&rest[..end.unwrap_or(rest.len())])
    };
    let at = node.range().start;
    // Namespaces are declared by attributes, which the parser does not list.
    let namespaces = node.namespaces().filter(|_| node == node.document().root_element());
    let declared = namespaces.filter_map(|namespace| {
        let name = namespace.name()?;
        let uri = namespace.uri();
        let name = format!("xmlns:{name}");
        (name != "xmlns:xml").then(|| Attribute {
            name: name.into(),
            value: uri.into(),
            place: place(at),
        })
    });
    let written = node.attributes().map(|attribute| Attribute {
        name: named(attribute.range().start),
        value: attribute.value().into(),
        place: place(attribute.range().start),
    });
    let attributes = declared.chain(written).collect();
    let children = node.children().filter_map(|child| {
        if child.is_element() {
            return Some(Node::Element(Rc::new(element(child, start))));
        }
        let text = child.text().filter(|_| child.is_text())?;
        Some(Node::Text(text.into(), place(child.range().start)))
    });
    Element { name: named(at + 1), place: place(at), attributes, children: children.collect() }
}
