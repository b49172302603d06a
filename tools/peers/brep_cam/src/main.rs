//! Drops a bull-nose cutter with BREP_cam: see tools/compare-peers for the work file and the
//! conversation on standard input and output.
use brep_cam::drop::DropCutter;
use brep_cam::{
    Cutter, FaceSource, MeshBuilder, NullSink, Point3, Runner, Tolerance, TreeIndex, TreeOptions,
    TriangleIndex,
};
use std::io::{BufRead, Write};
use std::time::Instant;

fn main() {
    let bytes = std::fs::read(std::env::args().nth(1).expect("work file")).expect("readable");
    let numbers: Vec<f64> = bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
        .collect();
    let (diameter, corner) = (numbers[0], numbers[1]);
    let (triangles, feet) = (numbers[2] as usize, numbers[3] as usize);
    let corners = &numbers[4..4 + 9 * triangles];
    let places = &numbers[4 + 9 * triangles..4 + 9 * triangles + 2 * feet];

    let tolerance = Tolerance::default();
    let mut builder = MeshBuilder::new(tolerance);
    let face = builder.add_face(FaceSource {
        solid: "part".into(),
        face: "all".into(),
        protected_only: false,
    });
    for t in corners.chunks_exact(9) {
        let point = |i: usize| Point3::new(t[3 * i], t[3 * i + 1], t[3 * i + 2]);
        builder.add_triangle(face, point(0), point(1), point(2)).expect("triangle");
    }
    let mesh = builder.finish();
    let index = TreeIndex::build(&mesh, TreeOptions::default());
    let cutter = Cutter::bull(diameter, corner, 100.0, 0.0);
    let dropper = DropCutter::new(&mesh, &cutter, Some(&index as &dyn TriangleIndex), tolerance)
        .expect("drop cutter");
    let xy: Vec<[f64; 2]> = places.chunks_exact(2).map(|p| [p[0], p[1]]).collect();

    println!("ready");
    let mut out = std::io::stdout();
    out.flush().unwrap();
    for line in std::io::stdin().lock().lines() {
        if line.is_err() {
            break;
        }
        let mut sink = NullSink;
        let mut runner = Runner::detached(&mut sink);
        let begin = Instant::now();
        let (points, _) = dropper.batch(&xy, -1000.0, &mut runner).expect("drops");
        let seconds = begin.elapsed().as_secs_f64();
        let heights: Vec<String> = points.iter().map(|p| format!("{:.17e}", p.z)).collect();
        writeln!(out, "{} {}", seconds, heights.join(" ")).unwrap();
        out.flush().unwrap();
    }
}
