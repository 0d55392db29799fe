//! What the table has for each version.

/// A field of a struct.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Field {
    /// Distance from the start of the struct \[byte\].
    pub(crate) offset: usize,
    /// Size \[byte\].
    pub(crate) bytes: usize,
}

/// What one version of MuJoCo was compiled with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// What `mj_version()` returns.
    pub(crate) version: i32,
    /// `mjModel`: length of qpos.
    pub(crate) nq: Field,
    /// `mjModel`: length of qvel.
    pub(crate) nv: Field,
    /// `mjModel`: length of ctrl.
    pub(crate) nu: Field,
    /// `mjModel`: step of the simulation.
    pub(crate) timestep: Field,
    /// `mjData`: bytes in `buffer`.
    pub(crate) buffer_len: Field,
    /// `mjData`: start of the memory its arrays lie in.
    pub(crate) buffer: Field,
    /// `mjData`: positions.
    pub(crate) qpos: Field,
    /// `mjData`: velocities.
    pub(crate) qvel: Field,
    /// `mjData`: array of warning statistics.
    pub(crate) warnings: Field,
    /// `mjWarningStat`: what the last warning was about.
    pub(crate) warning_index: Field,
    /// `mjWarningStat`: number of warnings.
    pub(crate) warning_count: Field,
    /// `mjSTATE_QPOS`.
    pub(crate) state_qpos: u32,
    /// `mjSTATE_QVEL`.
    pub(crate) state_qvel: u32,
    /// `mjSTATE_CTRL`.
    pub(crate) state_ctrl: u32,
    /// Index of the warning about bad positions.
    pub(crate) bad_qpos: usize,
    /// Index of the warning about bad velocities.
    pub(crate) bad_qvel: usize,
    /// Index of the warning about bad accelerations.
    pub(crate) bad_qacc: usize,
    /// Size of `mjWarningStat` \[byte\].
    pub(crate) warning_bytes: usize,
    /// Size of `mjVFS` \[byte\].
    pub(crate) vfs_bytes: usize,
}
