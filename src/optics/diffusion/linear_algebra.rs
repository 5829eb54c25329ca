//! Small dense matrices: Cholesky factors, the symmetric eigenproblem (cyclic Jacobi; Golub & Van Loan, "Matrix
//! Computations" §8.5), and linear systems.

/// A square matrix, row by row.
#[derive(Clone, Debug)]
pub(super) struct Matrix {
    n: usize,
    entries: Vec<f64>,
}

/// Sweeps of Jacobi's method; it converges quadratically after about eight.
const MOST_SWEEPS: usize = 30;

impl std::ops::Index<[usize; 2]> for Matrix {
    type Output = f64;
    fn index(&self, [row, column]: [usize; 2]) -> &f64 {
        &self.entries[row * self.n + column]
    }
}

impl std::ops::IndexMut<[usize; 2]> for Matrix {
    fn index_mut(&mut self, [row, column]: [usize; 2]) -> &mut f64 {
        &mut self.entries[row * self.n + column]
    }
}

impl Matrix {
    /// The matrix of `n` rows with these entries.
    pub fn new(n: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        Self { n, entries: (0..n * n).map(|i| entry(i / n, i % n)).collect() }
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * self.n..(row + 1) * self.n]
    }

    /// Aᵀ.
    pub fn transposed(&self) -> Self {
        Self::new(self.n, |i, j| self[[j, i]])
    }

    /// A·B.
    pub fn times(&self, other: &Self) -> Self {
        let columns = other.transposed();
        Self::new(self.n, |i, j| self.row(i).iter().zip(columns.row(j)).map(|(a, b)| a * b).sum())
    }

    /// L with A = LLᵀ, lower triangular, for a positive definite A.
    pub fn cholesky(&self) -> Self {
        let mut l = Self::new(self.n, |_, _| 0.0);
        for i in 0..self.n {
            for j in 0..=i {
                let dot: f64 = l.row(i)[..j].iter().zip(&l.row(j)[..j]).map(|(a, b)| a * b).sum();
                let rest = self[[i, j]] - dot;
                l[[i, j]] = if i == j { rest.max(f64::MIN_POSITIVE).sqrt() } else { rest / l[[j, j]] };
            }
        }
        l
    }

    /// L⁻ᵀB for a lower triangular L (this).
    pub fn solve_transposed(&self, b: &Self) -> Self {
        let mut x = b.clone();
        for i in (0..self.n).rev() {
            for k in i + 1..self.n {
                let factor = self[[k, i]];
                for j in 0..self.n {
                    x[[i, j]] -= factor * x[[k, j]];
                }
            }
            for j in 0..self.n {
                x[[i, j]] /= self[[i, i]];
            }
        }
        x
    }

    /// Eigenvalues of a symmetric matrix, and the eigenvectors as columns.
    pub fn eigen(mut self) -> (Vec<f64>, Self) {
        let n = self.n;
        // Vectors as rows, since rows lie together.
        let mut vectors = Self::new(n, |i, j| f64::from(u8::from(i == j)));
        for _ in 0..MOST_SWEEPS {
            let mut rotated = false;
            for p in 0..n {
                for q in p + 1..n {
                    let off = self[[p, q]];
                    if off.abs() <= f64::EPSILON * (self[[p, p]] * self[[q, q]]).abs().sqrt() {
                        continue;
                    }
                    rotated = true;
                    let theta = (self[[q, q]] - self[[p, p]]) / (2.0 * off);
                    let t = theta.signum() / (theta.abs() + (1.0 + theta * theta).sqrt());
                    let c = 1.0 / (1.0 + t * t).sqrt();
                    let s = t * c;
                    for k in 0..n {
                        let (a, b) = (self[[k, p]], self[[k, q]]);
                        self[[k, p]] = c * a - s * b;
                        self[[k, q]] = s * a + c * b;
                    }
                    self.rotate(p, q, c, s);
                    vectors.rotate(p, q, c, s);
                }
            }
            if !rotated {
                break;
            }
        }
        ((0..n).map(|i| self[[i, i]]).collect(), vectors.transposed())
    }

    fn rotate(&mut self, p: usize, q: usize, c: f64, s: f64) {
        for k in 0..self.n {
            let (a, b) = (self[[p, k]], self[[q, k]]);
            self[[p, k]] = c * a - s * b;
            self[[q, k]] = s * a + c * b;
        }
    }

    /// x with Ax = b, by elimination with partial pivoting.
    pub fn solve(mut self, mut b: Vec<f64>) -> Vec<f64> {
        let n = self.n;
        for i in 0..n {
            let pivot =
                (i..n).max_by(|&a, &b| self[[a, i]].abs().total_cmp(&self[[b, i]].abs())).unwrap_or(i);
            for k in 0..n {
                self.entries.swap(i * n + k, pivot * n + k);
            }
            b.swap(i, pivot);
            for row in i + 1..n {
                let factor = self[[row, i]] / self[[i, i]];
                for k in i..n {
                    self[[row, k]] -= factor * self[[i, k]];
                }
                b[row] -= factor * b[i];
            }
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| self[[i, k]] * b[k]).sum();
            b[i] = (b[i] - known) / self[[i, i]];
        }
        b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second difference, whose eigenvalues are 2 − 2 cos(kπ/(n+1)).
    fn second_difference(n: usize) -> Matrix {
        Matrix::new(n, |i, j| match i.abs_diff(j) {
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        })
    }

    #[test]
    fn eigenvalues_and_solutions_are_those_of_a_known_matrix() {
        let n = 12;
        let a = second_difference(n);
        let (mut values, vectors) = a.clone().eigen();
        let product = a.times(&vectors);
        for k in 0..n {
            for i in 0..n {
                assert!((product[[i, k]] - values[k] * vectors[[i, k]]).abs() < 1e-13);
            }
        }
        values.sort_by(f64::total_cmp);
        for (k, value) in values.iter().enumerate() {
            let expected = 2.0 - 2.0 * ((k + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
        // −x″ = 1 with zero ends: x_i = (i+1)(n−i)/2.
        let x = a.clone().solve(vec![1.0; n]);
        assert!((0..n).all(|i| (x[i] - 0.5 * ((i + 1) * (n - i)) as f64).abs() < 1e-12), "{x:?}");
        let l = a.cholesky();
        let back = l.times(&l.transposed());
        let inverse = l.solve_transposed(&l.transposed());
        for i in 0..n {
            for j in 0..n {
                assert!((back[[i, j]] - a[[i, j]]).abs() < 1e-14);
                assert!((inverse[[i, j]] - f64::from(u8::from(i == j))).abs() < 1e-13);
            }
        }
    }
}
