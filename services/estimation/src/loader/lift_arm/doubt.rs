//! What the doubts of the drawing do to payload and centre of gravity: each number moved by its standard deviation, one a row.
//!
//! A number that is off is off in every row, so nothing averages it out: its effect is added to the answer. Twenty rows go round, in
//! which an arm hardly moves.

use super::super::layout::Each;
use super::drawing::{Drawing, EMPTY_HEIGHT, EMPTY_RATIO, NUMBERS, Posture};
use crate::math::sqrt;

/// Squared effects of each number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Doubts {
    squares: [[f64; 3]; NUMBERS],
    sums: [f64; 3],
    next: usize,
}

impl Default for Doubts {
    fn default() -> Self {
        Self {
            squares: [[0.0; 3]; NUMBERS],
            sums: [0.0; 3],
            next: 0,
        }
    }
}

/// Standard deviations by all numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Doubt {
    pub payload: f64,
    pub centre: Each<f64>,
    /// Of the centre without the empty machine's: who measures that one otherwise has these left.
    pub moved: Each<f64>,
}

impl Doubts {
    /// Moves the next number by its standard deviation.
    pub fn see(&mut self, drawing: &Drawing, posture: &Posture, payload: f64) {
        let mut moved = drawing.values;
        moved[self.next] += drawing.std[self.next];
        let shift = drawing.payload(&moved, posture) - drawing.payload(&drawing.values, posture);
        let here = drawing.centre(&drawing.values, posture, payload);
        let there = drawing.centre(&moved, posture, payload + shift);
        let effects = [shift, there.ratio - here.ratio, there.height - here.height];
        self.squares[self.next] = effects.map(|x| x * x);
        self.next = (self.next + 1) % NUMBERS;
        self.sums = self.squares.iter().fold([0.0; 3], |sums, squares| {
            [0, 1, 2].map(|i| sums[i] + squares[i])
        });
    }

    /// Standard deviations of the answer.
    pub fn std(&self) -> Doubt {
        let [payload, ratio, height] = self.sums.map(sqrt);
        let without =
            |number: usize, i: usize| sqrt((self.sums[i] - self.squares[number][i]).max(0.0));
        Doubt {
            payload,
            centre: Each { ratio, height },
            moved: Each {
                ratio: without(EMPTY_RATIO, 1),
                height: without(EMPTY_HEIGHT, 2),
            },
        }
    }
}
