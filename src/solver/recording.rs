//! A frame of cloth as data: all that decides it, to be stepped again by another program, with the same bits.

use std::io::{self, Read, Write};
use std::sync::Arc;

use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

use super::anchors::Anchors;
use super::body::Body;
use super::detect::PartSettings;
use super::evaluate::{EvaluateSettings, Outcome, Pose};
use super::integrate::spring;
use super::island::{Island, Member, Stage, UntangleSettings};
use super::recover::{Level, Limits, diagnose};
use super::rest::RestShape;
use super::settings::{Fabric, Stepping};
use super::sim::ClothSim;
use super::skinned::Skinned;
use super::step::{FrameInput, Stepped, prepare, step};
use super::wind::Wind;

/// What files of this form begin with: the name and the number of the form. Another number is another form.
const MAGIC: &[u8; 8] = b"drape\0\0\x0b";
/// The version that wrote a file stands in it: what is recorded is private, and changes.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// FNV-1a (Fowler, Noll, Vo 1991) of 64 bits.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// A frame of cloths that were stepped together: what they were before it, what they were given, and where they were after it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Recording {
    /// Why it was recorded.
    pub reason: String,
    /// The cloths, in the order of their island.
    pub cloths: Vec<RecordedCloth>,
    /// Their island; none for a cloth that meets nothing.
    pub island: Option<Island>,
    /// Whether they were stepped side by side.
    pub together: bool,
    /// How they were untangled.
    pub untangle: UntangleSettings,
    /// By how much the frame of the island moved after they were stepped `[m]`.
    pub carried: Vec3,
    /// Time that passed `[s]`.
    pub dt: f32,
}

/// A cloth in a [`Recording`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RecordedCloth {
    /// Its name.
    pub name: String,
    /// Rest shape.
    pub rest: Arc<RestShape>,
    /// Material.
    pub fabric: Fabric,
    /// Substeps.
    pub stepping: Stepping,
    /// Pins.
    pub anchors: Anchors,
    /// Gravity `[m/s²]`.
    pub gravity: Vec3,
    /// Bodies.
    pub bodies: Vec<Body>,
    /// Wind.
    pub wind: Wind,
    /// What its skin asks of it.
    pub skinned: Option<Skinned>,
    /// See [`ClothSim`].
    pub sim: ClothSim,
    /// What is to be shown while it is tangled.
    pub evaluate: EvaluateSettings,
    /// What counts as a blow-up.
    pub limits: Limits,
    /// The animated pose, or the shape at rest where its carrier is `[m]`.
    pub pose: Vec<Vec3>,
    /// Whether that is an animated one.
    pub animated: bool,
    /// Whether its fabric or its pins changed since it was prepared.
    pub stale: bool,
    /// Where what carries it is.
    pub carrier: Pose,
    /// From its frame of simulation to that of the island while it is stepped, and after it `[m]`.
    pub offsets: [Vec3; 2],
    /// How it meets others after it was stepped.
    pub settings: PartSettings,
    /// Whether the app wrote its state before the frame, which is judged then.
    pub written: bool,
    /// See [`Member`].
    pub moves: bool,
    /// Time that passes by its clock `[s]`.
    pub clock: f32,
    /// See [`Member`].
    pub fixed: bool,
    /// See [`Member`].
    pub still: bool,
    /// See [`Member`].
    pub contact: bool,
    /// See [`Member`].
    pub at_load: bool,
    /// Where its particles were after the frame `[m]`, `w` inverse mass `[1/kg]`.
    pub after: Vec<Vec4>,
}

/// What stepping a [`Recording`] again gave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Replay {
    /// Particles that are not where they were, to the bit.
    pub differ: usize,
    /// Farthest distance of one from where it was `[m]`.
    pub farthest: f32,
    /// Edges that cross faces after the frame.
    pub crossings: u32,
    /// Whether a cloth is held.
    pub held: bool,
    /// Whether a cloth blew up and was taken back.
    pub recovered: bool,
    /// Largest edge length over rest length after the frame (dimensionless).
    pub worst_edge: f32,
}

/// A file that is no recording, or one that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// It begins otherwise.
    #[error("it is no recording of this version: record the frame again")]
    Form,
    /// What follows is damaged.
    #[error("the recording is damaged ({0}): record the frame again")]
    Damaged(String),
    /// It cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl RecordingError {
    fn cut() -> Self {
        Self::Damaged("its checksum does not fit".into())
    }
}

impl Recording {
    /// Writes it, to be read by [`Self::read`] of the same version.
    ///
    /// # Errors
    /// [`RecordingError::Io`] when `to` takes no more.
    pub fn write(&self, mut to: impl Write) -> Result<(), RecordingError> {
        let mut body = Vec::new();
        ciborium::into_writer(&(VERSION, self), &mut body).map_err(|error| RecordingError::Damaged(error.to_string()))?;
        to.write_all(MAGIC)?;
        to.write_all(&checksum(&body).to_le_bytes())?;
        to.write_all(&body)?;
        Ok(to.flush()?)
    }

    /// Reads what [`Self::write`] wrote. Nothing that was changed on the way is read: what is in a file is trusted by the
    /// solver.
    ///
    /// # Errors
    /// [`RecordingError`] when it is something else, damaged, or cannot be read.
    pub fn read(mut from: impl Read) -> Result<Self, RecordingError> {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes)?;
        let sum_and_body = bytes.strip_prefix(MAGIC).ok_or(RecordingError::Form)?;
        let (sum, body) = sum_and_body.split_first_chunk::<8>().ok_or_else(RecordingError::cut)?;
        if u64::from_le_bytes(*sum) != checksum(body) {
            return Err(RecordingError::cut());
        }
        let damaged = |error: ciborium::de::Error<io::Error>| RecordingError::Damaged(error.to_string());
        // The version stands first: what follows is read only if it is the same.
        let mut rest = body;
        let (version, recording): (String, ciborium::Value) = ciborium::from_reader(&mut rest).map_err(damaged)?;
        if version != VERSION {
            return Err(RecordingError::Form);
        }
        recording.deserialized().map_err(|error| RecordingError::Damaged(error.to_string()))
    }

    /// Steps the frame again.
    pub fn replay(&mut self) -> Replay {
        let Self { cloths, island, together, untangle, carried, dt, .. } = self;
        let mut replay = Replay::default();
        for cloth in cloths.iter_mut().filter(|cloth| cloth.moves && cloth.written) {
            let worst_edge = spring::strain(&cloth.rest.springs, &cloth.sim.state.positions).0;
            let limits = Limits { speed: f32::INFINITY, ..cloth.limits };
            if diagnose(&cloth.sim.state, worst_edge, &limits).is_some() {
                cloth.take_back(worst_edge, &limits);
                replay.recovered = true;
            }
        }
        for cloth in cloths.iter_mut().filter(|cloth| cloth.moves) {
            let ClothSim { state, memory, .. } = &mut cloth.sim;
            if cloth.stale || !memory.is_prepared_for(&cloth.rest) {
                prepare(&cloth.rest, &cloth.fabric, &cloth.anchors, state, memory);
            }
        }
        match island {
            Some(island) if *together => island.run(Stage::Integrate, *dt, untangle, &mut members(cloths, 0)),
            _ => {
                for cloth in cloths.iter_mut().filter(|cloth| cloth.moves) {
                    let Member { cloth, stepping, sim: ClothSim { state, memory, report, .. }, .. } = cloth.member(0);
                    *report = Some(step(cloth.rest, cloth.fabric, stepping, cloth.anchors, &cloth.input, state, memory));
                }
            }
        }
        for cloth in &mut *cloths {
            let Some(report) = cloth.sim.report.take() else { continue };
            let limits = cloth.limits;
            replay.recovered |= cloth.take_back(report.worst_edge, &limits);
        }
        if let Some(island) = island {
            for (part, cloth) in cloths.iter().enumerate() {
                island.tune(part, cloth.settings);
            }
            if *carried != Vec3::ZERO {
                island.carry(*carried);
            }
            let mut members = members(cloths, 1);
            for stage in Stage::AFTER_INTEGRATE {
                island.run(stage, *dt, untangle, &mut members);
            }
            replay.crossings = island.total().crossings;
        }
        for (part, cloth) in cloths.iter_mut().enumerate() {
            let RecordedCloth { rest, sim: ClothSim { state, display, .. }, evaluate, carrier, after, .. } = cloth;
            let (verdict, weights) = match island {
                Some(island) => (island.verdict(part), island.weights(part)),
                None => Default::default(),
            };
            let Outcome { shown, .. } = display.decide(&verdict, state, weights, *carrier, *dt, evaluate);
            replay.held |= shown == super::evaluate::Shown::Held;
            replay.worst_edge = replay.worst_edge.max(spring::strain(&rest.springs, &state.positions).0);
            let bits = |x: &Vec4| x.to_array().map(f32::to_bits);
            for (now, then) in state.positions.iter().zip(&*after).filter(|(now, then)| bits(now) != bits(then)) {
                replay.differ += 1;
                replay.farthest = replay.farthest.max(now.truncate().distance(then.truncate()));
            }
            replay.differ += state.positions.len().abs_diff(after.len());
        }
        replay
    }
}

/// The cloths as their island sees them before they are stepped, 0, or after, 1.
fn members(cloths: &mut [RecordedCloth], when: usize) -> Vec<Member<'_>> {
    cloths.iter_mut().map(|cloth| cloth.member(when)).collect()
}

impl RecordedCloth {
    /// Judges its state, and takes it back if it is bad; whether it was.
    fn take_back(&mut self, worst_edge: f32, limits: &Limits) -> bool {
        let Self { sim: ClothSim { state, memory, display, recovery, .. }, pose, .. } = self;
        let Some((level, _)) = recovery.judge(state, worst_edge, limits, |to| to.clone_from(pose)) else { return false };
        memory.forget();
        if level != Level::LastGood {
            display.reset();
        }
        true
    }

    fn member(&mut self, when: usize) -> Member<'_> {
        let dt = if self.moves { self.clock } else { 0.0 };
        let Self { rest, fabric, stepping, anchors, gravity, bodies, wind, skinned, sim, .. } = self;
        let input = FrameInput { dt, gravity: *gravity, bodies, wind, skinned: skinned.as_ref() };
        Member {
            cloth: Stepped { rest, fabric, anchors, input },
            stepping,
            sim,
            animation: if self.animated { Some(&self.pose) } else { None },
            offset: self.offsets[when],
            moves: self.moves,
            clock: self.clock,
            fixed: self.fixed,
            still: self.still,
            contact: self.contact,
            at_load: self.at_load,
            last_resort: self.evaluate.last_resort,
        }
    }
}
