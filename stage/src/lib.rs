//! The stage that the windowed examples share: a floor, soft light, a camera that orbits,
//! fabrics, and a way to run without a window.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use drape_stage::{OrbitCamera, Stage};
//!
//! fn setup() {}
//!
//! fn main() -> AppExit {
//!     let mut app = Stage::new("flag").camera(OrbitCamera::around(Vec3::Y, 3.0)).build();
//!     app.add_systems(Startup, setup).run()
//! }
//! ```
//!
//! With `--headless [--frames N] [--out FILE.png|gif]`, or without a display, the same app runs
//! for N steps of 1/60 s as fast as it can, and writes a picture if there is a graphics driver.
mod args;
pub mod cut;
mod display;
mod driver;
mod environment;
mod fabric;
mod floor;
mod gif;
pub mod hand;
mod headless;
mod hint;
mod legend;
mod light;
mod noise;
mod orbit;
mod palette;
mod picture;
mod quality;
mod report;
mod set;
mod shutter;
mod texture;

pub use args::StageArgs;
pub use fabric::{FabricLook, fabric};
pub use orbit::{OrbitCamera, PointerTaken};

use bevy::{
    app::PluginGroupBuilder,
    ecs::system::BoxedSystem,
    log::{Level, LogPlugin},
    prelude::*,
    render::{RenderPlugin, pipelined_rendering::PipelinedRenderingPlugin, settings::WgpuSettings},
    window::ExitCondition,
    winit::WinitPlugin,
};
use bevy_drape::{ClothDebug, ClothDebugPlugin, ClothLoading, ClothSolver};
use clap::Parser;
use headless::Job;
use picture::Picture;
use quality::Quality;

/// What an example may set about its stage before the app is built.
pub struct Stage {
    title: String,
    args: StageArgs,
    camera: OrbitCamera,
    hint: String,
    plugins: Box<dyn FnOnce(PluginGroupBuilder) -> PluginGroupBuilder>,
    report: Option<BoxedSystem<(), String>>,
    ready: Option<BoxedSystem<(), bool>>,
}

/// Where the app runs.
enum Venue {
    /// In a window.
    Window(Quality),
    /// Without one, drawing into a picture.
    Studio(Picture, Quality),
    /// Without drawing anything.
    Dark,
}

impl Stage {
    /// A stage for an example that has no options of its own.
    pub fn new(title: &str) -> Self {
        Self::from_args(title, StageArgs::parse())
    }

    /// A stage for an example that has parsed the command line itself.
    pub fn from_args(title: &str, args: StageArgs) -> Self {
        Self {
            title: title.into(),
            args,
            camera: OrbitCamera::around(Vec3::Y, 4.0),
            hint: String::new(),
            plugins: Box::new(|plugins| plugins),
            report: None,
            ready: None,
        }
    }

    /// Where the camera starts.
    pub fn camera(mut self, camera: OrbitCamera) -> Self {
        self.camera = camera;
        self
    }

    /// Words in the corner of the window, above those about the mouse.
    pub fn hint(mut self, hint: &str) -> Self {
        self.hint = hint.into();
        self
    }

    /// Changes Bevy's default plugins, for example the `GltfPlugin`.
    pub fn plugins(mut self, change: impl FnOnce(PluginGroupBuilder) -> PluginGroupBuilder + 'static) -> Self {
        self.plugins = Box::new(change);
        self
    }

    /// A system that returns lines for the report at the end of a run without a window.
    pub fn report<M>(mut self, system: impl IntoSystem<(), String, M> + 'static) -> Self {
        self.report = Some(Box::new(IntoSystem::into_system(system)));
        self
    }

    /// A system that returns whether all that the scene needs is loaded; a run without a window
    /// starts the clock only then.
    pub fn ready_when<M>(mut self, system: impl IntoSystem<(), bool, M> + 'static) -> Self {
        self.ready = Some(Box::new(IntoSystem::into_system(system)));
        self
    }

    /// The app with Bevy's plugins and the stage; the example adds its own and runs it.
    ///
    /// Ends the process if the command line asks for a picture that cannot be written.
    pub fn build(self) -> App {
        let picture = self.args.picture().unwrap_or_else(|line| {
            report::complain(&self.title, &line);
            std::process::exit(2)
        });
        let venue = venue(&self.title, &self.args, picture);
        let mut app = App::new();
        app.add_plugins((self.plugins)(plugins(&self.title, &venue)));
        match venue {
            Venue::Window(quality) => {
                set::window(&mut app, self.camera, quality, self.hint);
                // Where frames take longer, all goes slower together: cloth does not go further in one.
                let longest = core::time::Duration::from_secs_f32(ClothSolver::default().max_frame);
                app.insert_resource(Time::<Virtual>::from_max_delta(longest));
            }
            Venue::Studio(_, quality) => set::studio(&mut app, self.camera, quality),
            Venue::Dark => set::dark(&mut app, self.camera),
        }
        // In a window it can be switched on later, in the panel.
        if !self.args.debug.is_empty() || matches!(venue, Venue::Window(_)) {
            let items = self.args.debug.iter().map(String::as_str);
            app.add_plugins(ClothDebugPlugin)
                .insert_resource(ClothDebug::only(items))
                .add_systems(Update, legend::write.run_if(resource_changed::<ClothDebug>));
        }
        if !matches!(venue, Venue::Window(_)) {
            // A picture is the same on every machine.
            app.insert_resource(ClothLoading::AT_ONCE);
            let world = app.world_mut();
            let job = Job {
                title: self.title,
                frames: self.args.frame_count(),
                picture: if let Venue::Studio(picture, _) = venue { Some(picture) } else { None },
                report: self.report.map(|system| world.register_boxed_system(system)),
                ready: self.ready.map(|system| world.register_boxed_system(system)),
            };
            app.set_runner(move |app| headless::run(app, &job));
        }
        app
    }
}

/// Where the app can run, given what is asked for and what there is; says what is missing.
fn venue(title: &str, args: &StageArgs, picture: Option<Picture>) -> Venue {
    let headless = args.asks_for_headless();
    let no_display = if headless { None } else { display::missing() };
    if let Some(why) = &no_display {
        report::complain(title, &format!("{why}; running headless (--out FILE.png draws a picture)"));
    }
    let wants_window = !headless && no_display.is_none();
    match (driver::find(), picture) {
        (Err(why), _) => {
            report::complain(title, &format!("{why}; simulating without drawing anything"));
            Venue::Dark
        }
        (Ok(driver), Some(picture)) => {
            let quality = Quality::picture(picture.kind, &driver, args.width);
            Venue::Studio(picture, quality)
        }
        (Ok(driver), None) if wants_window => Venue::Window(Quality::window(&driver)),
        (Ok(_), None) => Venue::Dark,
    }
}

/// Bevy's plugins for a venue.
fn plugins(title: &str, venue: &Venue) -> PluginGroupBuilder {
    let anisotropy = match venue {
        Venue::Window(quality) | Venue::Studio(_, quality) => quality.anisotropy,
        Venue::Dark => 1,
    };
    let plugins = DefaultPlugins.set(ImagePlugin { default_sampler: texture::sampler(anisotropy) });
    if let Venue::Window(_) = venue {
        let window = Window { title: format!("bevy_drape: {title}"), ..default() };
        return plugins.set(WindowPlugin { primary_window: Some(window), ..default() });
    }
    let mut render = RenderPlugin { synchronous_pipeline_compilation: true, ..default() };
    if let Venue::Dark = venue {
        render.render_creation = WgpuSettings { backends: None, ..default() }.into();
    }
    plugins
        .disable::<WinitPlugin>()
        .disable::<PipelinedRenderingPlugin>()
        .set(render)
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(LogPlugin {
            level: Level::WARN,
            filter: "wgpu=error,naga=warn,bevy_render::renderer=error,bevy_render::extract_resource=off,\
                     bevy_gizmos_render=error"
                .into(),
            ..default()
        })
}
