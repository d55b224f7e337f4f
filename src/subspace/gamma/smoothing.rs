//! Gamma, smoothed over subspaces that are alike: with few paths for each pair of subspaces, the neighbours of a row know
//! more about it than its own few paths do. Smoothing after each step, as here, is EMS: Silverman, Jones,
//! Wilson, Nychka, A smoothed EM approach to indirect estimation problems, J. R. Stat. Soc. B 52(2), 1990.

use rayon::prelude::*;

/// Shares of the smoothed matrix that are tried.
const SHARES: [f64; 4] = [0.0, 0.1, 0.2, 0.4];

/// Which subspaces are alike: of each, itself and the nearest ones, or itself alone where nothing is known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbours {
    pub rows: Vec<Vec<u32>>,
    /// Columns that can be drawn only have neighbours that can be.
    pub columns: Vec<Vec<u32>>,
}

/// A linear map of matrices whose rows are distributions to such matrices.
#[derive(Clone, Debug)]
pub(super) struct Smoothing {
    /// Rows whose mean is taken; none where a row stays as it is.
    rows: Vec<Vec<u32>>,
    /// Where a column's probability goes, and which share of it.
    columns: Vec<Vec<(u32, f64)>>,
    /// Of the smoothed matrix beside the one that is smoothed: the only one, or what there is to choose from.
    pub shares: Vec<f64>,
}

impl Smoothing {
    /// `power`: of each column, in any unit. Rows that were not learnt stay as they are, and do not count for others. Without
    /// a `share` there are several to choose from.
    pub fn new(neighbours: &Neighbours, power: &[f64], learnt: &[bool], share: Option<f64>) -> Self {
        let of_row = |(row, near): (usize, &Vec<u32>)| match learnt[row] {
            true => near.iter().copied().filter(|&near| learnt[near as usize]).collect(),
            false => Vec::new(),
        };
        // As if the neighbours were one subspace: inside a subspace, light vertices are drawn by power.
        let of_column = |(column, near): (usize, &Vec<u32>)| {
            let total: f64 = near.iter().map(|&near| power[near as usize]).sum();
            match total > 0.0 {
                true => near.iter().map(|&near| (near, power[near as usize] / total)).collect(),
                false => vec![(column as u32, 1.0)],
            }
        };
        Self {
            rows: neighbours.rows.iter().enumerate().map(of_row).collect(),
            columns: neighbours.columns.iter().enumerate().map(of_column).collect(),
            shares: share.map_or(SHARES.to_vec(), |share| vec![share]),
        }
    }

    pub fn apply(&self, q: &[f64]) -> Vec<f64> {
        let k = self.columns.len();
        let mut spread = vec![0.0; q.len()];
        spread.par_chunks_mut(k).zip(q.par_chunks(k)).for_each(|(out, row)| {
            for (q, columns) in row.iter().zip(&self.columns).filter(|(q, _)| **q > 0.0) {
                columns.iter().for_each(|&(column, share)| out[column as usize] += q * share);
            }
        });
        let mut smoothed = q.to_vec();
        smoothed.par_chunks_mut(k).zip(&self.rows).filter(|(_, rows)| !rows.is_empty()).for_each(
            |(out, rows)| {
                out.fill(0.0);
                for row in rows {
                    let row = &spread[*row as usize * k..][..k];
                    out.iter_mut().zip(row).for_each(|(out, q)| *out += q / rows.len() as f64);
                }
            },
        );
        smoothed
    }
}
