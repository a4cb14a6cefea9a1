//! How the states of a map are cut into tiles.

/// States on a grid, cut into hyper-rectangles; slowest dimension first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tiling {
    /// States along each dimension.
    pub shape: Vec<usize>,
    /// States of a tile along each dimension; tiles at the end may have fewer.
    pub tile: Vec<usize>,
}

/// One tile: the first state and the number of states along each dimension.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Its first state.
    pub origin: Vec<usize>,
    /// Its states along each dimension.
    pub extent: Vec<usize>,
}

impl Tiling {
    /// Tiles along each dimension.
    pub fn grid(&self) -> Vec<usize> {
        let along = |(states, tile): (&usize, &usize)| states.div_ceil(*tile);
        self.shape.iter().zip(&self.tile).map(along).collect()
    }

    /// The number of tiles.
    pub fn tiles(&self) -> usize {
        self.grid().iter().product()
    }

    /// The number of states.
    pub fn states(&self) -> usize {
        self.shape.iter().product()
    }

    /// Where a tile is among the tiles; they are numbered with the last dimension running fastest.
    pub fn position(&self, tile: usize) -> Vec<usize> {
        unravel(tile, &self.grid())
    }

    /// A tile by its number.
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
    /// The number of its states.
    pub fn states(&self) -> usize {
        self.extent.iter().product()
    }

    /// The number, in a map of a shape, of the state at a place in this tile.
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

/// The place of the element with a number in an array of a shape, last dimension running fastest.
pub(crate) fn unravel(mut index: usize, shape: &[usize]) -> Vec<usize> {
    let mut place = vec![0; shape.len()];
    for (place, states) in place.iter_mut().zip(shape).rev() {
        (*place, index) = (index % states, index / states);
    }
    place
}

/// The number of the element at a place.
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
