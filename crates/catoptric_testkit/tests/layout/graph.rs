//! Circles in directed graphs.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// The nodes that each node leads to.
pub(crate) type Graph = BTreeMap<String, BTreeSet<String>>;

/// The strongly connected components of several nodes (Tarjan, Depth-First Search and Linear Graph Algorithms, 1972).
pub(crate) fn circles(graph: &Graph) -> Vec<BTreeSet<String>> {
    let mut search = Search { graph, found: BTreeMap::new(), open: Vec::new(), circles: Vec::new() };
    for node in graph.keys() {
        if !search.found.contains_key(node.as_str()) {
            search.visit(node);
        }
    }
    search.circles
}

struct Search<'a> {
    graph: &'a Graph,
    /// The order in which nodes were found.
    found: BTreeMap<&'a str, usize>,
    open: Vec<&'a str>,
    circles: Vec<BTreeSet<String>>,
}

impl<'a> Search<'a> {
    /// The earliest open node that is reached from a node that was not visited yet.
    fn visit(&mut self, node: &'a str) -> usize {
        let number = self.found.len();
        self.found.insert(node, number);
        self.open.push(node);
        let mut earliest = number;
        for next in self.graph.get(node).into_iter().flatten() {
            let reached = match self.found.get(next.as_str()) {
                None => self.visit(next),
                Some(reached) if self.open.contains(&next.as_str()) => *reached,
                Some(_) => continue,
            };
            earliest = earliest.min(reached);
        }
        if earliest == number {
            let begin = self.open.iter().position(|open| *open == node).expect("it was opened above");
            let circle: BTreeSet<String> = self.open.drain(begin..).map(String::from).collect();
            if circle.len() > 1 {
                self.circles.push(circle);
            }
        }
        earliest
    }
}

/// The shortest way from one node to another, both included.
pub(crate) fn shortest_way(graph: &Graph, from: &str, to: &str) -> Option<Vec<String>> {
    let mut before = BTreeMap::from([(from, None)]);
    let mut queue = VecDeque::from([from]);
    while let Some(node) = queue.pop_front() {
        if node == to {
            let mut way: Vec<String> =
                std::iter::successors(Some(node), |node| before[node]).map(String::from).collect();
            way.reverse();
            return Some(way);
        }
        for next in graph.get(node).into_iter().flatten() {
            if !before.contains_key(next.as_str()) {
                before.insert(next, Some(node));
                queue.push_back(next);
            }
        }
    }
    None
}
