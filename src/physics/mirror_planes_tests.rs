use super::*;
#[test]
fn the_whole_is_the_sum_over_the_part_and_its_images() {
    let vector = Vector3::new(2.0, -3.0, 5.0);
    for planes in [[false, false], [true, false], [false, true], [true, true]] {
        let mut images = vec![Vector3::repeat(1.0)];
        for axis in (0..2).filter(|axis| planes[*axis]) {
            let mirrored = images.clone().into_iter().map(|mut image| {
                image[axis] = -image[axis];
                image
            });
            images.extend(mirrored);
        }
        let mirror = MirrorPlanes(planes);
        assert_eq!(mirror.copies() as usize, images.len());
        let whole: Vector3<f64> = images.iter().map(|image| image.component_mul(&vector)).sum();
        assert_eq!(mirror.whole(vector), whole, "{planes:?}");
        // What moves or turns alike with every image is free; a turn is a product of two directions.
        let same = |of: &dyn Fn(&Vector3<f64>) -> f64| f64::from(u8::from(images.iter().all(|i| of(i) == 1.0)));
        let moves = Vector3::new(same(&|i| i.x), same(&|i| i.y), same(&|i| i.z));
        let turns = Vector3::new(same(&|i| i.y * i.z), same(&|i| i.z * i.x), same(&|i| i.x * i.y));
        assert_eq!(mirror.freedom(), [moves, turns], "{planes:?}");
        assert_eq!(mirror.names().len(), planes.iter().filter(|plane| **plane).count());
    }
    assert_eq!(MirrorPlanes([false, true]).names(), ["y"]);
}
