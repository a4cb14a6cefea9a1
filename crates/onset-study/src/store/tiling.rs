//! Division of the states of a map into tiles.

/// States on a grid, divided into boxes; slowest dimension first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tiling {
    /// Number of states along each dimension.
    pub shape: Vec<usize>,
    /// Number of states of a tile along each dimension; tiles at the end may be smaller.
    pub tile: Vec<usize>,
}

/// Tile of a map: the first state and the number of states along each dimension.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Indices of the first state.
    pub origin: Vec<usize>,
    /// Number of states along each dimension.
    pub extent: Vec<usize>,
}

impl Tiling {
    /// Number of tiles along each dimension.
    pub fn grid(&self) -> Vec<usize> {
        let along = |(states, tile): (&usize, &usize)| states.div_ceil(*tile);
        self.shape.iter().zip(&self.tile).map(along).collect()
    }

    /// Total number of tiles.
    pub fn tiles(&self) -> usize {
        self.grid().iter().product()
    }

    /// Total number of states.
    pub fn states(&self) -> usize {
        self.shape.iter().product()
    }

    /// Indices of a tile along each dimension; tiles are numbered with the last dimension varying fastest.
    pub fn position(&self, tile: usize) -> Vec<usize> {
        unravel(tile, &self.grid())
    }

    /// Tile with the given number.
    pub fn at(&self, tile: usize) -> Tile {
        let origin: Vec<usize> = self
            .position(tile)
            .iter()
            .zip(&self.tile)
            .map(|(index, states)| index * states)
            .collect();
        let extent = origin
            .iter()
            .zip(self.shape.iter().zip(&self.tile))
            .map(|(first, (all, states))| (*states).min(all - first))
            .collect();
        Tile { origin, extent }
    }
}

impl Tile {
    /// Number of states in the tile.
    pub fn states(&self) -> usize {
        self.extent.iter().product()
    }

    /// Number, in a map of the given shape, of the state at the given indices in this tile.
    pub fn state(&self, place: &[usize], shape: &[usize]) -> usize {
        place
            .iter()
            .zip(&self.origin)
            .zip(shape)
            .fold(0, |index, ((place, origin), states)| {
                index * states + origin + place
            })
    }
}

/// Indices of an element in an array, from its number, the last dimension varying fastest.
pub(crate) fn unravel(mut index: usize, shape: &[usize]) -> Vec<usize> {
    let mut place = vec![0; shape.len()];
    for (place, states) in place.iter_mut().zip(shape).rev() {
        (*place, index) = (index % states, index / states);
    }
    place
}

/// Number of an element in an array, from its indices, the last dimension varying fastest.
pub(crate) fn ravel(place: &[usize], shape: &[usize]) -> usize {
    place
        .iter()
        .zip(shape)
        .fold(0, |index, (place, states)| index * states + place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_hold_every_state_exactly_once() {
        let tiling = Tiling {
            shape: vec![5, 7, 4],
            tile: vec![2, 3, 4],
        };
        let mut seen = vec![0; tiling.states()];
        for number in 0..tiling.tiles() {
            let tile = tiling.at(number);
            for index in 0..tile.states() {
                let place = unravel(index, &tile.extent);
                assert_eq!(ravel(&place, &tile.extent), index);
                seen[tile.state(&place, &tiling.shape)] += 1;
            }
        }
        assert!(seen.iter().all(|count| *count == 1));
        assert_eq!(tiling.grid(), [3, 3, 1]);
    }
}
