//! Attributes of elements and of their default classes, for those that mjcf-rs does not read.

use std::collections::BTreeMap;

use roxmltree::Node;

/// The classes of a model.
pub struct Classes<'n> {
    by_name: BTreeMap<&'n str, Node<'n, 'n>>,
    /// The outermost classes, which all elements have.
    main: Vec<Node<'n, 'n>>,
}

impl<'n> Classes<'n> {
    /// Returns the classes under `root`.
    pub fn new(root: Node<'n, 'n>) -> Self {
        let is_class = |node: &Node| node.has_tag_name("default");
        let named = root.descendants().filter(is_class);
        let by_name = named.filter_map(|node| Some((node.attribute("class")?, node))).collect();
        Self { by_name, main: root.children().filter(is_class).collect() }
    }

    /// Returns the value of an attribute: of the element, or of its class, or of the class around that.
    pub fn attribute(&self, node: Node<'n, 'n>, name: &str) -> Option<&'n str> {
        let of_bodies = || node.ancestors().skip(1).find_map(|up| up.attribute("childclass"));
        let class = node.attribute("class").or_else(of_bodies);
        let own = class.and_then(|class| self.by_name.get(class));
        let around = own.into_iter().flat_map(|class| class.ancestors());
        let mut chain = around.chain(self.main.iter().copied());
        let of_class = |class: Node<'n, 'n>| {
            let elements = class.children().filter(|child| child.tag_name() == node.tag_name());
            elements.filter_map(|element| element.attribute(name)).next_back()
        };
        node.attribute(name).or_else(|| chain.find_map(of_class))
    }
}
