//! The vase and a concave dish against a dense search of their parameters, by formulas of its own.

use super::*;
use catoptric_core::surface::{Quadric, Revolution};
use glam::{DMat2, Vec3};

/// A surface by parameters from 0 to 1 (the second may be periodic), placed in the world.
struct Parametric {
    local: fn(DVec2) -> DVec3,
    periodic: bool,
    /// The depth of parameters inside the surface's border; below 0 beyond it.
    inside: fn(DVec2) -> f64,
    place: Affine3A,
    /// The box that ends of paths are drawn from, in the surface's frame.
    ends: [Vec3; 2],
}

/// A node of the grid: position and tangents.
#[derive(Clone, Copy)]
struct GridNode {
    at: DVec3,
    tangents: [DVec3; 2],
}

/// A root of the dense search, with measures of its doubtfulness.
struct Root {
    at: DVec3,
    doubtful: bool,
}

const VASE: [f64; 4] = [5.80, -9.78, 3.90, 0.47];
const VASE_HEIGHT: f64 = 2.0;

/// Radius and depth of the dish, `y = depth (x^2 + z^2) / radius^2`.
const DISH: [f64; 2] = [1.5, 1.5];

/// The least distance of ends from the surface: three cells of the coarsest grid.
const MIN_DISTANCE: f64 = 0.1;

fn place() -> Affine3A {
    Affine3A::from_rotation_translation(Quat::from_rotation_z(0.5), Vec3::new(0.25, 0.5, -1.0))
}

fn vase() -> (PlacedSurface, Parametric) {
    let surface = AnalyticSurface::Revolution(Revolution::new(VASE_HEIGHT, VASE).expect("the surface is valid"));
    let local = |p: DVec2| {
        let [a, b, c, d] = VASE;
        let (radius, angle) = (((a * p.x + b) * p.x + c) * p.x + d, p.y * std::f64::consts::TAU);
        DVec3::new(radius * angle.cos(), VASE_HEIGHT * p.x, radius * angle.sin())
    };
    let ends = [Vec3::new(-3.0, -1.0, -3.0), Vec3::new(3.0, 4.0, 3.0)];
    let parametric = Parametric { local, periodic: true, inside: |p| p.x.min(1.0 - p.x), place: place(), ends };
    (PlacedSurface { surface, world_from_surface: place().as_daffine3() }, parametric)
}

fn dish() -> (PlacedSurface, Parametric) {
    let [radius, depth] = DISH;
    let k = depth / (radius * radius);
    let quadric = [-k, 0.0, -k, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let surface =
        Quadric::new(quadric, [-radius, -0.1, -radius], [radius, depth, radius]).expect("the surface is valid");
    let local = |p: DVec2| {
        let [radius, depth] = DISH;
        let flat = (p * 2.0 - 1.0) * radius;
        DVec3::new(flat.x, depth * flat.length_squared() / (radius * radius), flat.y)
    };
    let inside = |p: DVec2| 1.0 - (p * 2.0 - 1.0).length();
    let ends = [Vec3::new(-1.0, 0.1, -1.0), Vec3::new(1.0, 2.0, 1.0)];
    let parametric = Parametric { local, periodic: false, inside, place: place(), ends };
    (
        PlacedSurface { surface: AnalyticSurface::Quadric(surface), world_from_surface: place().as_daffine3() },
        parametric,
    )
}

impl Parametric {
    fn at(&self, p: DVec2) -> DVec3 {
        let matrix = glam::Mat3::from(self.place.matrix3).as_dmat3();
        matrix * (self.local)(p) + Vec3::from(self.place.translation).as_dvec3()
    }

    fn node(&self, p: DVec2) -> GridNode {
        let step = 1e-5;
        let tangent = |axis: DVec2| {
            let difference = |h: f64| (self.at(p + axis * h) - self.at(p - axis * h)) / (2.0 * h);
            (difference(step) * 4.0 - difference(2.0 * step)) / 3.0
        };
        GridNode { at: self.at(p), tangents: [tangent(DVec2::X), tangent(DVec2::Y)] }
    }

    fn residual(node: &GridNode, ends: &[DVec3; 2]) -> DVec2 {
        let half: DVec3 = ends.iter().map(|end| (*end - node.at).normalize()).sum();
        DVec2::from(node.tangents.map(|tangent| half.dot(tangent.normalize())))
    }

    fn grid(&self, cells: [usize; 2]) -> Vec<GridNode> {
        let nodes = (0..=cells[0]).flat_map(|i| (0..=cells[1]).map(move |j| [i, j]));
        nodes.map(|[i, j]| self.node(DVec2::new(i as f64 / cells[0] as f64, j as f64 / cells[1] as f64))).collect()
    }

    /// All reflections: Newton's method from every cell over which both components may vanish, with room for as much
    /// change again as the corners show.
    fn reflections(&self, cells: [usize; 2], grid: &[GridNode], ends: &[DVec3; 2]) -> Vec<Root> {
        let residuals: Vec<DVec2> = grid.iter().map(|node| Self::residual(node, ends)).collect();
        let mut roots: Vec<Root> = Vec::new();
        let mut places: Vec<DVec2> = Vec::new();
        for i in 0..cells[0] {
            for j in 0..cells[1] {
                let corner = i * (cells[1] + 1) + j;
                let corners = [corner, corner + 1, corner + cells[1] + 1, corner + cells[1] + 2].map(|k| residuals[k]);
                let low = corners.into_iter().reduce(DVec2::min).expect("there are corners");
                let high = corners.into_iter().reduce(DVec2::max).expect("there are corners");
                let room = high - low;
                if (low - room).max_element() > 0.0 || (high + room).min_element() < 0.0 {
                    continue;
                }
                let start = DVec2::new((i as f64 + 0.5) / cells[0] as f64, (j as f64 + 0.5) / cells[1] as f64);
                let Some((mut p, conditioning)) = self.newton(start, ends) else { continue };
                if self.periodic {
                    p.y = p.y.rem_euclid(1.0);
                }
                let node = self.node(p);
                let known = |other: &DVec2| self.at(*other).distance(node.at) < 1e-7;
                if (self.inside)(p) < -1e-4 || places.iter().any(known) {
                    continue;
                }
                let normal = node.tangents[0].cross(node.tangents[1]).normalize();
                let [a, b] = ends.map(|end| (end - node.at).normalize().dot(normal));
                let grazing = a.abs().min(b.abs()) < 1e-5;
                if a * b > 0.0 || grazing {
                    places.push(p);
                    let at_the_border = (self.inside)(p).abs() < 1e-4;
                    roots.push(Root { at: node.at, doubtful: conditioning < 1e-3 || at_the_border || grazing });
                }
            }
        }
        roots
    }

    /// A root near the start, and how far from singular the constraint is there (0 to 1).
    fn newton(&self, start: DVec2, ends: &[DVec3; 2]) -> Option<(DVec2, f64)> {
        let mut p = start;
        let step = 1e-5;
        for _ in 0..30 {
            let residual = |p: DVec2| Self::residual(&self.node(p), ends);
            let column = |axis: DVec2| (residual(p + axis * step) - residual(p - axis * step)) / (2.0 * step);
            let matrix = DMat2::from_cols(column(DVec2::X), column(DVec2::Y));
            let change = matrix.inverse() * residual(p);
            if change.length() >= 0.1 || change.is_nan() {
                return None;
            }
            p -= change;
            if change.length() < 1e-9 {
                let size = matrix.x_axis.length_squared() + matrix.y_axis.length_squared();
                return Some((p, 2.0 * matrix.determinant().abs() / size));
            }
        }
        None
    }
}

/// Counts of random configurations by their result.
#[derive(Debug, Default)]
struct ComparisonCounts {
    agreed: usize,
    /// Configurations with different lists and a root at the border, nearly multiple or nearly grazing.
    doubtful: usize,
    /// The numbers of configurations, by the count of roots.
    counts: Vec<usize>,
}

fn compare(
    (surface, parametric): (PlacedSurface, Parametric),
    cells: [usize; 2],
    cases: usize,
    seed: u64,
) -> ComparisonCounts {
    let finder = RootFinder::new(&surface);
    let grid = parametric.grid(cells);
    let mut random = Stream::new(seed);
    let mut outcome = ComparisonCounts { counts: vec![0; 32], ..ComparisonCounts::default() };
    while outcome.agreed + outcome.doubtful < cases {
        let ends = [0; 2].map(|_| {
            let [low, high] = parametric.ends;
            let share = Vec3::from([0; 3].map(|_| random.next_unit()));
            place().transform_point3(low + (high - low) * share).as_dvec3()
        });
        // The grid does not resolve an end that is as near to the surface as the grid is fine.
        if grid.iter().any(|node| ends.iter().any(|end| end.distance_squared(node.at) < MIN_DISTANCE.powi(2))) {
            continue;
        }
        let expected = parametric.reflections(cells, &grid, &ends);
        let mut found = Vec::new();
        let count = finder.roots(&Eye::Point(ends[0]), ends[1], BounceKind::Reflect, 1.0, &mut found);
        assert_eq!(count, RootCount::Finite, "{ends:?}");
        let same = |root: &DVec3, other: &DVec3| root.distance(*other) < 1e-6;
        let invented = found.iter().any(|root| !expected.iter().any(|other| same(root, &other.at)));
        let missed = expected.iter().any(|root| !found.iter().any(|other| same(&root.at, other)));
        if !invented && !missed && found.len() == expected.len() {
            outcome.agreed += 1;
            outcome.counts[found.len()] += 1;
        } else if expected.iter().any(|root| root.doubtful) {
            outcome.doubtful += 1;
        } else {
            let expected: Vec<_> = expected.iter().map(|root| root.at).collect();
            panic!("{ends:?}: {found:?} against {expected:?}");
        }
    }
    outcome
}

#[test]
fn reflections_in_a_vase_are_those_of_a_dense_search() {
    let outcome = compare(vase(), [100, 200], 60, 11);
    assert!(outcome.agreed >= 59 && outcome.counts[3..].iter().sum::<usize>() > 5, "{outcome:?}");
}

#[test]
fn reflections_in_a_dish_are_those_of_a_dense_search() {
    let outcome = compare(dish(), [100, 100], 60, 12);
    assert!(outcome.agreed >= 59 && outcome.counts[2..].iter().sum::<usize>() > 5, "{outcome:?}");
}

#[test]
#[ignore = "10,000 cases each: run it with --release"]
fn reflections_in_vase_and_dish_are_those_of_a_dense_search_in_many_cases() {
    for (name, surface, cells) in [("vase", vase(), [400, 800]), ("dish", dish(), [400, 400])] {
        let outcome = compare(surface, cells, 10_000, 13);
        eprintln!("{name}: {outcome:?}");
        assert!(outcome.doubtful < 50, "{name}: {outcome:?}");
    }
}
