//! Pictures in rows, one picture out.

use super::{FigureError, Raster, check_size};

impl Raster {
    /// Pictures row by row, side by side from the left, tops aligned; white where there is none.
    pub fn grid(rows: &[Vec<Self>]) -> Result<Self, FigureError> {
        let row_width = |row: &Vec<Self>| row.iter().map(|p| u64::from(p.width)).sum::<u64>();
        let row_height = |row: &Vec<Self>| row.iter().map(|p| p.height).max().unwrap_or(0);
        let width = rows.iter().map(row_width).max().unwrap_or(0);
        let height = rows.iter().map(|row| u64::from(row_height(row))).sum();
        check_size(width, height)?;
        let mut rgb = Vec::with_capacity(3 * (width * height) as usize);
        for row in rows {
            for y in 0..row_height(row) as usize {
                let end = rgb.len() + 3 * width as usize;
                for picture in row.iter().filter(|p| y < p.height as usize) {
                    let line = 3 * picture.width as usize;
                    rgb.extend_from_slice(&picture.rgb[y * line..(y + 1) * line]);
                }
                rgb.resize(end, u8::MAX);
            }
        }
        Self::from_rgb(width as u32, height as u32, rgb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_where_they_belong() {
        let gray = |width, height, v| {
            Raster::from_rgb(width, height, vec![v; 3 * (width * height) as usize]).unwrap()
        };
        let grid = Raster::grid(&[vec![gray(2, 2, 1), gray(3, 2, 2)], vec![gray(4, 1, 3)]]).unwrap();
        assert_eq!((grid.width(), grid.height()), (5, 3));
        let at = |x, y| grid.pixel(x, y).unwrap()[0];
        assert_eq!([at(1, 1), at(2, 0), at(4, 1), at(3, 2), at(4, 2)], [1, 2, 2, 3, 255]);
        assert!(Raster::grid(&[]).is_err());
    }
}
