//! `umbrage render`: one method on one view.

use super::args::RenderArgs;
use super::failure::Failure;
use super::folder::Folder;
use super::measure;
use super::pictures;
use super::print;
use super::progress::Progress;
use super::results::{LightErrors, SamplingErrors, Stats, write_json};
use super::setup;
use glam::Vec3;
use std::path::Path;
use umbrage::lab::Lab;
use umbrage::methods::{self, DebugPicture};
use umbrage::output::{OutputError, Picture, write_exr, write_png};
use umbrage::truth::GBuffer;

/// Renders, measures and writes the results.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let folder = Folder::open(&args.out)?;
    let progress = Progress::new(args.common.quiet);
    let lab = setup::open(&args.common, &progress)?;
    let mut methods = [methods::create(&args.method, &lab)?];
    let bar = progress.bar("rendering");
    let timings = measure::by_turns(&lab, &mut methods, args.frames, |share| bar.at(share))?.pop().unwrap_or_default();
    drop(bar);
    let [method] = &mut methods;

    let visibility = measure::visibility(&lab, method.as_mut())?;
    let gbuffer = lab.gbuffer()?;
    let image = pictures::shaded(&lab, &gbuffer, &visibility)?;
    let statistics = method.statistics(&lab)?;
    let sampling = measure::sampling(&lab, method.as_mut())?;
    let mut debug = if args.debug { method.debug_pictures(&lab)? } else { Vec::new() };
    if let Some(first) = sampling.first().filter(|_| args.debug) {
        debug.extend(first.pictures()?);
    }
    let mut stats = Stats::new(&lab, &args.method.text, &timings, method.memory(), statistics);
    stats.sampling = sampling.iter().map(SamplingErrors::of).collect();
    let mut difference = None;
    if args.truth {
        let references = setup::references(&lab, &progress)?;
        stats.truth = Some(LightErrors::of(&visibility, &references)?);
        difference = Some(pictures::difference(&lab, &gbuffer, &visibility, &references)?);
    }
    setup::validated(&lab)?;

    folder.fill(|at| {
        write_png(&at.join("image.png"), &image)?;
        write_visibility(&at.join("visibility.exr"), lab.view().size, &visibility)?;
        write_gbuffer(&at.join("gbuffer.exr"), &lab, &gbuffer)?;
        write_json(&at.join("view.json"), lab.view())?;
        write_json(&at.join("stats.json"), &stats)?;
        if let Some(difference) = &difference {
            write_png(&at.join("difference.png"), difference)?;
        }
        for DebugPicture { name, width, height, rgb } in debug {
            write_png(&at.join(format!("debug_{name}.png")), &Picture { width, height, rgb })?;
        }
        Ok(())
    })?;
    if !args.common.quiet {
        print::out(&summary(&stats, &args.out));
    }
    Ok(())
}

/// Channel `V.i` for light i of the view, and `V` for the first.
fn write_visibility(path: &Path, [width, height]: [u32; 2], visibility: &[Vec<f32>]) -> Result<(), OutputError> {
    let names: Vec<_> = (0..visibility.len()).map(|light| format!("V.{light}")).collect();
    let each = names.iter().map(String::as_str).zip(visibility);
    let first = visibility.first().map(|image| ("V", image));
    let channels: Vec<_> = first.into_iter().chain(each).map(|(name, image)| (name, image.as_slice())).collect();
    write_exr(path, width, height, &channels)
}

/// World positions and normals as float32; all channels are 0 where there is no surface.
fn write_gbuffer(path: &Path, lab: &Lab, gbuffer: &GBuffer) -> Result<(), OutputError> {
    let pixels = 0..gbuffer.hit.len();
    let point = |i| if gbuffer.hit[i] { (lab.scene().origin + gbuffer.point(i)).as_vec3() } else { Vec3::ZERO };
    let points: Vec<Vec3> = pixels.map(point).collect();
    let position = [0, 1, 2].map(|k| points.iter().map(|p| p[k]).collect::<Vec<_>>());
    let normal = [0, 1, 2].map(|k| gbuffer.normal.iter().map(|n| n[k]).collect::<Vec<_>>());
    let hit: Vec<f32> = gbuffer.hit.iter().map(|&hit| f32::from(u8::from(hit))).collect();
    let [px, py, pz] = &position;
    let [nx, ny, nz] = &normal;
    let channels: [(&str, &[f32]); 7] =
        [("P.X", px), ("P.Y", py), ("P.Z", pz), ("N.X", nx), ("N.Y", ny), ("N.Z", nz), ("hit", &hit)];
    write_exr(path, gbuffer.width, gbuffer.height, &channels)
}

fn summary(stats: &Stats, out: &Path) -> String {
    let ms = stats.ms;
    let mut text = format!(
        "{} on {}: {:.2} ms ({:.2} to {:.2}) after the depth prepass, {:.1} MiB\n",
        stats.method,
        stats.device,
        ms.median,
        ms.min,
        ms.max,
        print::mib(stats.bytes.total)
    );
    if let Some(LightErrors { all: e, .. }) = &stats.truth {
        text += &format!(
            "against ray tracing: mismatch {:.4} %, edge_error {:.2} %, off_edge {:.4} %, lost {:.4} %\n",
            e.mismatch, e.edge_error, e.off_edge, e.lost
        );
    }
    text + &format!("results are in {}\n", out.display())
}
