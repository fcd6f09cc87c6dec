//! The nodes of a scene and where they place their meshes.

use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf_json::{Index, Node, Root};

use super::GlbError;
use super::accessor::named;

/// A mesh and where it is placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) node: usize,
    pub(super) mesh: usize,
    pub(super) transform: DMat4,
}

/// Every mesh of the default scene, or of the first one, in the order in which a walk of its trees
/// meets them, parents before children. A file without scenes gives the trees of all nodes that are
/// nobody's children.
pub(super) fn placed_meshes(root: &Root) -> Result<Vec<Placed>, GlbError> {
    let mut found = Vec::new();
    let mut reached = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, DMat4)> = Vec::new();
    let (roots, of) = root_nodes(root)?;
    push(&mut stack, root, roots, &of, DMat4::IDENTITY)?;
    while let Some((index, parent)) = stack.pop() {
        let node = &root.nodes[index];
        if std::mem::replace(&mut reached[index], true) {
            return Err(GlbError::NotATree { node: index });
        }
        let transform = parent * local_transform(index, node)?;
        if let Some(mesh) = node.mesh {
            named(&root.meshes, "mesh", mesh.value(), &format!("node {index}"))?;
            found.push(Placed { node: index, mesh: mesh.value(), transform });
        }
        let children = node.children.iter().flatten().map(Index::value).collect();
        push(&mut stack, root, children, &format!("node {index}"), transform)?;
    }
    Ok(found)
}

fn root_nodes(root: &Root) -> Result<(Vec<usize>, String), GlbError> {
    let index = root.scene.map_or(0, |scene| scene.value());
    if root.scenes.is_empty() && root.scene.is_none() {
        let mut is_child = vec![false; root.nodes.len()];
        for child in root.nodes.iter().filter_map(|node| node.children.as_ref()).flatten() {
            if let Some(entry) = is_child.get_mut(child.value()) {
                *entry = true;
            }
        }
        let roots = (0..root.nodes.len()).filter(|&node| !is_child[node]).collect();
        return Ok((roots, "the file".to_owned()));
    }
    let scene = named(&root.scenes, "scene", index, "the file")?;
    Ok((scene.nodes.iter().map(Index::value).collect(), format!("scene {index}")))
}

/// Puts nodes on the stack so that the first is taken first.
fn push(
    stack: &mut Vec<(usize, DMat4)>,
    root: &Root,
    nodes: Vec<usize>,
    of: &str,
    parent: DMat4,
) -> Result<(), GlbError> {
    for &node in nodes.iter().rev() {
        named(&root.nodes, "node", node, of)?;
        stack.push((node, parent));
    }
    Ok(())
}

/// A node's matrix, or scale, then rotation, then translation.
fn local_transform(index: usize, node: &Node) -> Result<DMat4, GlbError> {
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        if matrix.row(3) != DVec4::W {
            let what = "a matrix that is not affine".to_owned();
            return Err(GlbError::Unsupported { place: format!("node {index}"), what });
        }
        return Ok(matrix);
    }
    let vector = |v: Option<[f32; 3]>, default: DVec3| v.map_or(default, |v| DVec3::from_array(v.map(f64::from)));
    let scale = vector(node.scale, DVec3::ONE);
    let translation = vector(node.translation, DVec3::ZERO);
    // Single precision leaves a unit quaternion a little off one. A zero quaternion has no direction
    // and becomes NaN, which is refused at the first vertex.
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| {
        let q = DQuat::from_array(q.0.map(f64::from));
        if q == DQuat::IDENTITY { q } else { q * (1.0 / q.length()) }
    });
    Ok(DMat4::from_scale_rotation_translation(scale, rotation, translation))
}
