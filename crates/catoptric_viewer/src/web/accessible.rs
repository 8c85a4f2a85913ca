//! The window's widgets as egui describes them to assistive technology, which pages hand to nobody of themselves.

use eframe::egui::accesskit::{Node, NodeId, Role, TreeUpdate};
use eframe::egui::{Context, FullOutput, Plugin};
use serde::Serialize;
use std::collections::HashMap;

/// A widget of the window.
#[derive(Clone, Serialize)]
struct Widget {
    /// The kind of widget, such as `CheckBox`.
    role: String,
    /// The name by which it is announced.
    label: String,
    /// The text or number that it holds.
    value: String,
    /// Left, top, width and height in points.
    rect: [f64; 4],
}

/// Keeps the widgets of the last frame, once they have been asked for.
#[derive(Default)]
pub(super) struct Accessible {
    widgets: Vec<Widget>,
}

impl Accessible {
    /// The widgets of the last frame, as JSON; none before the next frame if nobody has asked for them before.
    pub(super) fn read(window: &Context) -> String {
        if window.plugin_opt::<Self>().is_none() {
            window.add_plugin(Self::default());
            window.enable_accesskit();
            window.request_repaint();
        }
        let widgets = window.with_plugin(|accessible: &mut Self| accessible.widgets.clone());
        serde_json::json!(widgets.unwrap_or_default()).to_string()
    }
}

impl Plugin for Accessible {
    fn debug_name(&self) -> &'static str {
        "accessible"
    }

    fn output_hook(&mut self, _window: &Context, output: &mut FullOutput) {
        if let Some(update) = &output.platform_output.accesskit_update {
            self.widgets = widgets(update);
        }
    }
}

/// All nodes that have a place, but for the lines that texts are broken into.
fn widgets(update: &TreeUpdate) -> Vec<Widget> {
    let nodes: HashMap<NodeId, &Node> = update.nodes.iter().map(|(id, node)| (*id, node)).collect();
    let own_name = |node: &Node| node.label().or_else(|| node.value()).unwrap_or_default().to_owned();
    let label = |node: &Node| match node.label() {
        Some(label) => label.to_owned(),
        None => node.labelled_by().iter().filter_map(|id| nodes.get(id)).map(|node| own_name(node)).collect(),
    };
    let widget = |(_, node): &(NodeId, Node)| {
        let place = node.bounds().filter(|_| node.role() != Role::TextRun)?;
        let number = || node.numeric_value().map(|number| number.to_string());
        Some(Widget {
            role: format!("{:?}", node.role()),
            label: label(node),
            value: node.value().map(str::to_owned).or_else(number).unwrap_or_default(),
            rect: [place.x0, place.y0, place.width(), place.height()],
        })
    };
    update.nodes.iter().filter_map(widget).collect()
}
