use onset::bloch::*; use onset::method::*; use onset::material::*; use onset::kinematics::*; use onset::verdict::*;
use std::time::Instant;
fn main() {
    let mat = ModifiedMooneyRivlin::default();
    for (frame, lat, lin) in [(Frame::Lagrangian, CurrentLattice::Convected, Linearization::Exact),(Frame::Eulerian, CurrentLattice::Convected, Linearization::Exact),(Frame::Eulerian, CurrentLattice::Regular, Linearization::Paper)] {
        let m = Method::<2>::new(Discretization{frame, lattice: lat, linearization: lin, ..Default::default()}).unwrap();
        let f = DeformationGradient::from_stretches([0.97,0.93,1.0]).unwrap();
        let n: u32 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(200);
        let t=Instant::now(); for _ in 0..n { std::hint::black_box(mat.response(&f).unwrap()); } let a=t.elapsed()/n;
        let t=Instant::now(); for _ in 0..n { std::hint::black_box(dynamical_matrix(&m,&mat,&f).unwrap()); } let b=t.elapsed()/n;
        let z=zone_search(&m,&mat,&f).unwrap(); let d=dynamical_matrix(&m,&mat,&f).unwrap();
        let t=Instant::now(); for _ in 0..n { std::hint::black_box(z.stability(&d).1); } let c=t.elapsed()/n;
        let t=Instant::now(); for _ in 0..n { std::hint::black_box(z.summary(&d)); } let e=t.elapsed()/n;
        let t=Instant::now(); for _ in 0..n { std::hint::black_box(d.at(&nalgebra::vector![1.0,0.3])); } let g=t.elapsed()/n;
        let t=Instant::now(); for _ in 0..n { std::hint::black_box(z.long_wave_limit(&d)); } let h=t.elapsed()/n;
        println!("{frame:?} {lat:?} {lin:?}: response {a:?} matrix {b:?} is_stable {c:?} ({:?}) summary {e:?} at {g:?} lw {h:?}", z.stability(&d).1);
    }
}
