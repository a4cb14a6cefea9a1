//! One frame of particles.

use crate::error::Place;
use std::collections::HashMap;

/// Particles at one time. All lists have one entry for each particle, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time; `None` if neither the file nor the user gives it.
    pub time: Option<f64>,
    /// Number of the time step; `None` if the file does not give it.
    pub step: Option<u64>,
    /// Place of the frame.
    pub source: Place,
    /// Number of dimensions in the file, 1 to 3; further components of positions, displacements and velocities are zero.
    pub dimensions: usize,
    /// IDs of the particles; `None` if the file has no IDs.
    pub identity: Option<Vec<u64>>,
    /// Current position of each particle; length in the units of the run.
    pub position: Vec<[f64; 3]>,
    /// Reference position of each particle; length. `None` if the file has no reference positions.
    pub reference: Option<Vec<[f64; 3]>>,
    /// Current minus reference position of each particle; length. `None` if the file has no displacements.
    pub displacement: Option<Vec<[f64; 3]>>,
    /// Velocity of each particle; length/time. `None` if the file has no velocities.
    pub velocity: Option<Vec<[f64; 3]>>,
    /// Deformation gradients F_iJ, row by row as in the file; see [`ColumnUse::order_is_assumed`](crate::ColumnUse::order_is_assumed). `None` if the
    /// file has no gradients.
    pub gradient: Option<Vec<[f64; 9]>>,
    /// Components of the gradients that the file contains. The remaining components equal the identity.
    pub gradient_given: [bool; 9],
    /// Cauchy stresses xx, yy, zz, xy, xz, yz, in the units of the run. `None` if the file has no stresses.
    pub stress: Option<Vec<[f64; 6]>>,
    /// Components of the stresses that the file contains; the others are set to zero and are unknown.
    pub stress_given: [bool; 6],
    /// Current density of each particle; mass/volume. `None` if the file has no densities.
    pub density: Option<Vec<f64>>,
    /// Volume of each particle or cell, in the units of the run. `None` if the file has no volumes.
    pub volume: Option<Vec<f64>>,
    /// Mass of each particle. `None` if the file has no masses.
    pub mass: Option<Vec<f64>>,
    /// Type or material of each particle. `None` if the file has no types.
    pub kind: Option<Vec<i64>>,
    /// Whether the motion of each particle is prescribed. `None` if the file does not mark such particles.
    pub held: Option<Vec<bool>>,
    /// Elements or cells between the points. `None` if the file has only points.
    pub cells: Option<Cells>,
    /// Box of the simulation with its periodic directions. `None` if the file has no box.
    pub bounds: Option<Bounds>,
    /// Whether positions may be wrapped into a periodic box: the file has neither unwrapped positions nor image flags.
    pub may_be_wrapped: bool,
}

/// Elements or cells between the points of a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// Points of all cells, one cell after the other; all are below the number of points.
    pub connectivity: Vec<usize>,
    /// End of each cell in `connectivity`, ascending.
    pub ends: Vec<usize>,
    /// Shapes of the cells, in the numbering of VTK.
    pub shapes: Vec<u8>,
    /// Deformation gradients F_iJ, row by row as in the file. `None` if the cells have no gradients.
    pub gradient: Option<Vec<[f64; 9]>>,
    /// Components of the gradients that the file contains.
    pub gradient_given: [bool; 9],
    /// Cauchy stresses xx, yy, zz, xy, xz, yz, in the units of the run. `None` if the file has no stresses.
    pub stress: Option<Vec<[f64; 6]>>,
    /// Components of the stresses that the file contains.
    pub stress_given: [bool; 6],
    /// Current density of each cell; mass/volume. `None` if the cells have no densities.
    pub density: Option<Vec<f64>>,
    /// Volume of each particle or cell, in the units of the run. `None` if the file has no volumes.
    pub volume: Option<Vec<f64>>,
    /// Number of the material of each cell. `None` if the cells have no such numbers.
    pub kind: Option<Vec<i64>>,
}

/// Box of a simulation, which may be tilted, with its periodic directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounds {
    /// Lower corner of the box.
    pub low: [f64; 3],
    /// Upper corner, without tilt.
    pub high: [f64; 3],
    /// Tilt factors xy, xz, yz; length.
    pub tilt: [f64; 3],
    /// Directions along which the box is repeated.
    pub periodic: [bool; 3],
}

impl Bounds {
    /// Vector of the box from its lower corner, at scaled coordinates 0 to 1.
    pub fn vector(&self, scaled: [f64; 3]) -> [f64; 3] {
        let side: [f64; 3] = std::array::from_fn(|axis| self.high[axis] - self.low[axis]);
        let [xy, xz, yz] = self.tilt;
        let [a, b, c] = scaled;
        [
            a * side[0] + b * xy + c * xz,
            b * side[1] + c * yz,
            c * side[2],
        ]
    }
}

/// Differences between the particles of a frame and a list of IDs; see [`Frame::in_order_of`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Order {
    /// IDs that are missing from the frame.
    pub missing: Vec<u64>,
    /// IDs that occur only in the frame; these particles are removed.
    pub new: Vec<u64>,
    /// IDs that occur more than once in the frame; the first occurrence is kept.
    pub doubled: Vec<u64>,
}

impl Order {
    /// Returns true if the frame has exactly the listed particles.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty() && self.new.is_empty() && self.doubled.is_empty()
    }
}

impl Frame {
    /// Returns the number of particles in the frame.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Returns true if the frame has no particles.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// IDs that occur more than once, ascending.
    pub fn doubled(&self) -> Vec<u64> {
        let mut sorted = self.identity.clone().unwrap_or_default();
        sorted.sort_unstable();
        let pairs = sorted.windows(2).filter(|pair| pair[0] == pair[1]);
        let mut doubled: Vec<u64> = pairs.map(|pair| pair[0]).collect();
        doubled.dedup();
        doubled
    }

    /// Sorts the particles in the order of the given IDs, and returns the differences. A frame without IDs remains unchanged.
    ///
    /// Missing particles are omitted: the frame then has fewer particles than `ids`. Cells that lose a point are removed. `ids` contains no
    /// duplicates; see [`Frame::doubled`].
    pub fn in_order_of(&mut self, ids: &[u64]) -> Order {
        let mut order = Order::default();
        let Some(own) = &self.identity else {
            return order;
        };
        if own == ids {
            return Order::default();
        }
        order.doubled = self.doubled();
        let mut places: HashMap<u64, (usize, bool)> = HashMap::with_capacity(own.len());
        for (place, id) in own.iter().enumerate() {
            places.entry(*id).or_insert((place, false));
        }
        let mut chosen = Vec::with_capacity(ids.len());
        for id in ids {
            match places.get_mut(id) {
                Some((place, is_used)) if !*is_used => {
                    *is_used = true;
                    chosen.push(*place);
                }
                Some(_) => {}
                None => order.missing.push(*id),
            }
        }
        let unused = places.iter().filter(|(_, (_, is_used))| !is_used);
        order.new = unused.map(|(id, _)| *id).collect();
        order.new.sort_unstable();
        self.select(&chosen);
        order
    }

    /// Keeps the given particles, in the given order.
    fn select(&mut self, chosen: &[usize]) {
        fn pick<T: Copy>(from: &mut Vec<T>, chosen: &[usize]) {
            *from = chosen.iter().map(|place| from[*place]).collect();
        }
        fn maybe<T: Copy>(from: &mut Option<Vec<T>>, chosen: &[usize]) {
            if let Some(from) = from {
                pick(from, chosen);
            }
        }
        let count = self.position.len();
        pick(&mut self.position, chosen);
        maybe(&mut self.identity, chosen);
        maybe(&mut self.reference, chosen);
        maybe(&mut self.displacement, chosen);
        maybe(&mut self.velocity, chosen);
        maybe(&mut self.gradient, chosen);
        maybe(&mut self.stress, chosen);
        maybe(&mut self.density, chosen);
        maybe(&mut self.volume, chosen);
        maybe(&mut self.mass, chosen);
        maybe(&mut self.kind, chosen);
        maybe(&mut self.held, chosen);
        if let Some(cells) = &mut self.cells {
            let mut moved = vec![usize::MAX; count];
            for (new, old) in chosen.iter().enumerate() {
                moved[*old] = new;
            }
            cells.renumber(&moved);
        }
    }
}

impl Cells {
    /// Returns the number of cells in the frame.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns true if there are no cells.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Points of one cell.
    pub fn points(&self, cell: usize) -> &[usize] {
        let start = cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.connectivity[start..self.ends[cell]]
    }

    /// Renumbers the points, and removes cells with omitted points (`usize::MAX`).
    fn renumber(&mut self, moved: &[usize]) {
        let kept: Vec<usize> = (0..self.len())
            .filter(|cell| {
                self.points(*cell)
                    .iter()
                    .all(|point| moved[*point] != usize::MAX)
            })
            .collect();
        let (mut connectivity, mut ends) = (Vec::new(), Vec::new());
        for cell in &kept {
            connectivity.extend(self.points(*cell).iter().map(|point| moved[*point]));
            ends.push(connectivity.len());
        }
        fn maybe<T: Copy>(from: &mut Option<Vec<T>>, kept: &[usize]) {
            if let Some(from) = from {
                *from = kept.iter().map(|cell| from[*cell]).collect();
            }
        }
        self.shapes = kept.iter().map(|cell| self.shapes[*cell]).collect();
        maybe(&mut self.gradient, &kept);
        maybe(&mut self.stress, &kept);
        maybe(&mut self.density, &kept);
        maybe(&mut self.volume, &kept);
        maybe(&mut self.kind, &kept);
        (self.connectivity, self.ends) = (connectivity, ends);
    }
}
