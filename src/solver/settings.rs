//! What the user sets: material and solver parameters in SI units, independent of mesh resolution.

/// Mechanical properties of a fabric. All values are SI and independent of the mesh's resolution.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Fabric {
    /// Areal density `[kg/m²]`. Default 0.2, range 0.01 to 10. Too low for the substep rate: springs look stiffer than they
    /// are.
    pub density: f32,
    /// Membrane stiffness along the threads `[N/m]`: tension per unit of width for a strain of one.
    /// A spring gets `k = K · ΣA / L²` (Van Gelder 1998). Default 2000, range 0 to 1e7.
    pub stretch_stiffness: f32,
    /// Shear stiffness `G` `[N/m]`: force per unit of width at an angle of one radian, held by the diagonals of quads or by
    /// triangles. Default 50, range 0 to 1e7. 0: shears freely.
    pub shear_stiffness: f32,
    /// Bending stiffness `B` `[N·m]`: moment per unit of width and curvature, of the quadratic isometric model (Bergou et al.
    /// 2006). Default 1e-5, range 0 to 1.
    pub bend_stiffness: f32,
    /// Stretch stiffness along the warp over that along the weft (dimensionless),
    /// [`stretch_stiffness`](Self::stretch_stiffness) being their mean. Default 1, range 0.1 to 10. Without texture coordinates
    /// that tell the warp nothing.
    pub stretch_ratio: f32,
    /// Bending stiffness along the warp over that along the weft (dimensionless), [`bend_stiffness`](Self::bend_stiffness)
    /// being their mean. Default 1, range 0.1 to 10. Without texture coordinates that tell the warp nothing.
    pub bend_ratio: f32,
    /// Angle of the warp from `v` towards `u` of the texture `[rad]`, as a piece is cut. Default 0, range -π to π.
    pub warp_angle: f32,
    /// Curvature that the friction between yarns holds `[1/m]`: the moment of hysteresis over the stiffness, `HB / B` (2HB and
    /// B of Kawabata 1980). Default 0, range 0 to 1000. What was pressed to `κ` stays at `(κ - HB / B) / 2`, and at `HB / B` at
    /// most; 0: folds open all the way, and swing.
    pub bend_hysteresis: f32,
    /// Damping of the springs `[1/s]`: rate at which stretching velocity decays. Default 2, range 0 to 1000.
    pub damping: f32,
    /// Linear damping `[1/s]`: rate at which every velocity decays, whatever the wind. Default 0.1, range 0 to 100.
    pub drag: f32,
    /// Largest elongation of an edge, as a fraction of its rest length (Provot 1995). Default 0.05, range 0 to 10; infinite:
    /// off.
    pub strain_limit: f32,
    /// Thickness of the fabric `[m]`: distance kept to bodies, and centre to centre between layers. Default 0.005, range 1e-4
    /// to 1.
    pub thickness: f32,
    /// Static friction coefficient (dimensionless). Default 0.5, range 0 to 10. Combined with a body's by the geometric mean.
    pub static_friction: f32,
    /// Dynamic friction coefficient (dimensionless). Default 0.4, range 0 to 10.
    pub dynamic_friction: f32,
    /// Speed with which it leaves what it struck, over that with which it met it (dimensionless). Default 0, range 0 to 1. Of
    /// two cloths the larger counts; what meets at less than 0.25 m/s does not bounce.
    pub restitution: f32,
    /// Length of tethers over the geodesic rest distance to the pin (dimensionless). Default 1.0, range 0.1 to 10; infinite:
    /// off.
    pub tether_scale: f32,
    /// Aerodynamic drag coefficient across the surface (dimensionless). Default 1.2, range 0 to 10.
    pub drag_coefficient: f32,
    /// Aerodynamic lift coefficient (dimensionless). Default 0.6, range 0 to 10.
    pub lift_coefficient: f32,
}

impl Fabric {
    /// Values from which masses and factors of constraints are computed. They are density `[kg/m²]`, stiffness against stretch
    /// and shear `[N/m]` and against bending `[N·m]`. The ratios along the warp (dimensionless) follow, then its angle `[rad]`,
    /// and whether yarns rub (0 or 1). While these and the pins stay, [`prepare`](super::step::prepare) need not be called.
    #[must_use]
    pub fn prepared(&self) -> [f32; 8] {
        let rubs = f32::from(u8::from(self.bend_hysteresis > 0.0));
        let Self { density, stretch_stiffness, shear_stiffness, bend_stiffness, stretch_ratio, bend_ratio, warp_angle, .. } =
            *self;
        [density, stretch_stiffness, shear_stiffness, bend_stiffness, stretch_ratio, bend_ratio, warp_angle, rubs]
    }
}

impl Default for Fabric {
    fn default() -> Self {
        Self {
            density: 0.2,
            stretch_stiffness: 2000.0,
            shear_stiffness: 50.0,
            bend_stiffness: 1.0e-5,
            stretch_ratio: 1.0,
            bend_ratio: 1.0,
            warp_angle: 0.0,
            bend_hysteresis: 0.0,
            damping: 2.0,
            drag: 0.1,
            strain_limit: 0.05,
            thickness: 0.005,
            static_friction: 0.5,
            dynamic_friction: 0.4,
            restitution: 0.0,
            tether_scale: 1.0,
            drag_coefficient: 1.2,
            lift_coefficient: 0.6,
        }
    }
}

/// Speed at which one pass over the membrane in each step has to carry tension along the cloth `[m/s]`. From there on cloth
/// drapes as its fabric does. Drape coefficients of silk, cotton and denim on edges of 5 to 15 mm are within three points of
/// those of more steps.
const TENSION_SPEED: f32 = 11.0;

/// Steps per second `[Hz]` from which a mesh with edges of `mean_edge` `[m]` drapes as its fabric does; it hangs limper with
/// fewer.
#[must_use]
pub fn drape_rate(mean_edge: f32) -> f32 {
    TENSION_SPEED / mean_edge
}

/// How a frame is cut into substeps.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Stepping {
    /// Substeps per second of simulated time `[Hz]`. Default 360, range 30 to 10,000. A frame of `dt` takes `ceil(dt · rate)`.
    /// It takes up to eight times as many while a body that moves much faster than the pins is near. So it does where gravity
    /// would let cloth fall by more than an edge in one.
    pub substep_rate: f32,
    /// Longest frame that is simulated `[s]`; time beyond it is counted as lost, never simulated in one leap. Above
    /// 0; default 0.1.
    pub max_frame: f32,
    /// Most inner steps per second `[Hz]`. Default 3000, range 30 to 6000: the fall in a shorter step is no more than rounding.
    /// The mesh may ask for more steps ([`drape_rate`]) than there are substeps. Each substep is then cut into inner steps for
    /// all except contacts and bounds on lengths.
    pub inner_rate: f32,
    /// What holds the cloth together in its plane. Default [`MembraneModel::Auto`].
    pub membrane: MembraneModel,
}

/// What holds a cloth together in its plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum MembraneModel {
    /// Springs where edges run along the threads, triangles where they do not and texture coordinates tell the threads.
    #[default]
    Auto,
    /// A spring on each edge (Provot 1995): exact on grids along the threads, stiff against shearing on any other mesh.
    Springs,
    /// Strain of triangles (Müller et al. 2014): the same on every mesh. Springs where nothing tells the threads.
    Triangles,
}

impl Default for Stepping {
    fn default() -> Self {
        Self { substep_rate: 360.0, max_frame: 0.1, inner_rate: 3000.0, membrane: MembraneModel::Auto }
    }
}
