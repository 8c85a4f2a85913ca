//! {{title}}: one sentence on the idea.
//!
//! See this folder's `README.md`.

{{modules}}

{{layout_use}}pub use settings::{{type}}Settings;

use catoptric_core::clock::Stopwatch;
use catoptric_engine::error::RenderError;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_engine::method::bake::Baked;
{{draw_use}}
use catoptric_engine::method::{About, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings};
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};
{{role_use}}
use std::sync::Arc;

/// The method's entry in the registry.
pub static INFO: MethodInfo = MethodInfo {
    id: "{{name}}",
    family: Family::{{family_type}},
    summary: "one line for tables",
    paper: "author year, title",
    assumptions: "what must hold for its pictures to be right",
    about: About {
        readme: include_str!("README.md"),
        draws: "the parts of a picture that it draws, and how",
        costs: "the time and memory that it takes, beforehand and in each frame",
        cannot: "the faults that its pictures are known to have",
        useful: &["size"],
    },
    cpu: true,
    gpu: false,
    bake: {{bake}},
    settings: {{type}}Settings::describe,
    effective: {{type}}Settings::effective,
    limits: &limits::LIMITS,
    create: |table| Ok(Box::new({{type}} { settings: {{type}}Settings::from_table(table)? })),
};

/// The method with its settings.
struct {{type}} {
    settings: {{type}}Settings,
}

/// The tables of a scene.
struct Prepared{{type}} {
    settings: {{type}}Settings,
    scene: Arc<Scene>,
    quality: Quality,
    tables: {{type}}Tables,
    report: Report,
}

/// One view.
struct {{type}}Frame<'a> {
    prepared: &'a Prepared{{type}},
    view: View,
}

impl Method for {{type}} {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        INFO.refuse_bake(bake)?;
        Ok(Box::new(Prepared{{type}}::new(&self.settings, scene, quality, progress)?))
    }
}

impl Prepared{{type}} {
    fn new(
        settings: &{{type}}Settings,
        scene: &Arc<Scene>,
        quality: Quality,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let mut watch = Stopwatch::new();
        let tables = {{type}}Tables::build(settings, scene, progress)?;
        let report = Report { stages_ms: vec![("build", watch.lap_ms())], ..Report::default() };
        Ok(Self { settings: settings.clone(), scene: scene.clone(), quality, tables, report })
    }
}

impl Prepared for Prepared{{type}} {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.settings, scene, quality, progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new({{type}}Frame { prepared: self, view: view.clone() }))
    }
}

impl Frame for {{type}}Frame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let Prepared{{type}} { scene, quality, tables, .. } = self.prepared;
        let job = Job { scene, view: &self.view, quality: *quality, progress };
{{draw}}
        // To be removed when reflectors are drawn.
        report.fallbacks.insert("reflectors_drawn_black", scene.specular_objects().len() as u64);
        Ok(report)
    }
}
