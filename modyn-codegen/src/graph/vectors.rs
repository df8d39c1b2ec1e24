//! Vectors of nodes.

use super::{Graph, Id, Node};

impl Graph {
    /// Returns the nodes of a unit vector of `length` entries, whose entry `at` is 1.
    pub fn unit_vector(&mut self, length: usize, at: usize) -> Vec<Id> {
        let zero = self.constant(0.0);
        let one = self.constant(1.0);
        (0..length).map(|k| if k == at { one } else { zero }).collect()
    }

    /// Returns the node of a sum of products, which are added in their order.
    pub fn sum_of_products(&mut self, products: impl IntoIterator<Item = (Id, Id)>) -> Id {
        let zero = self.constant(0.0);
        products.into_iter().fold(zero, |sum, (a, b)| {
            let product = self.make(Node::Mul(a, b));
            self.make(Node::Add(sum, product))
        })
    }

    /// Returns the node of a sum, whose terms are added in pairs. There must be terms.
    pub fn pairwise_sum(&mut self, terms: &[Id]) -> Id {
        let [term] = terms else {
            let (a, b) = terms.split_at(terms.len() / 2);
            let a = self.pairwise_sum(a);
            let b = self.pairwise_sum(b);
            return self.make(Node::Add(a, b));
        };
        *term
    }
}
