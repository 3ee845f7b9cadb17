//! The node tree: parents before children, and which nodes the scene shows.

use super::file::{File, find};

/// The order in which node transforms can be accumulated.
pub(super) struct Tree {
    /// All nodes, parents first.
    pub(super) order: Vec<usize>,
    /// Parent of each node.
    pub(super) parent: Vec<Option<usize>>,
    /// Nodes of the default scene, else the first scene, else all nodes; in depth-first order.
    pub(super) shown: Vec<usize>,
}

impl Tree {
    /// Checks that the nodes form a forest.
    pub(super) fn new(file: &File) -> Result<Self, String> {
        let nodes = &file.root.nodes;
        let mut parent = vec![None; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            for child in node.children.iter().flatten() {
                find(nodes, child.value(), "node")?;
                if let Some(other) = parent[child.value()].replace(i) {
                    return Err(format!("node {child} is a child of both node {other} and node {i}"));
                }
            }
        }
        let roots: Vec<usize> = (0..nodes.len()).filter(|&i| parent[i].is_none()).collect();
        let order = descend(file, &roots);
        if order.len() < nodes.len() {
            let mut reached = vec![false; nodes.len()];
            order.iter().for_each(|&i| reached[i] = true);
            let node = reached.iter().position(|r| !r).unwrap_or_default();
            return Err(format!("node {node} is part of a cycle; nodes must form a tree"));
        }
        let shown = match scene_roots(file)? {
            Some(scene) => descend(file, &scene),
            None => order.clone(),
        };
        Ok(Self { order, parent, shown })
    }
}

fn scene_roots(file: &File) -> Result<Option<Vec<usize>>, String> {
    let scenes = &file.root.scenes;
    let index = file.root.scene.map(|s| s.value());
    if index.is_none() && scenes.is_empty() {
        return Ok(None);
    }
    let scene = find(scenes, index.unwrap_or(0), "scene")?;
    scene.nodes.iter().try_for_each(|n| find(&file.root.nodes, n.value(), "node").map(|_| ()))?;
    Ok(Some(scene.nodes.iter().map(|n| n.value()).collect()))
}

/// Depth-first order without recursion; a node that is reached again is left out.
fn descend(file: &File, roots: &[usize]) -> Vec<usize> {
    let nodes = &file.root.nodes;
    let mut seen = vec![false; nodes.len()];
    let mut order = Vec::new();
    let mut stack: Vec<usize> = roots.iter().rev().copied().collect();
    while let Some(i) = stack.pop() {
        if std::mem::replace(&mut seen[i], true) {
            continue;
        }
        order.push(i);
        stack.extend(nodes[i].children.iter().flatten().rev().map(|c| c.value()));
    }
    order
}
