//! Single sort routine for items of all kinds.

/// Sorts by increasing value; items with equal values keep their order. Only the values are sorted, so that the program contains a single sort for
/// all types of items.
pub(crate) fn sort_by_value<T>(items: &mut [T], value: impl Fn(&T) -> f64) {
    let mut order: Vec<(f64, usize)> = items.iter().map(value).zip(0..).collect();
    sort(&mut order);
    for place in 0..items.len() {
        // The item at this position may already have been moved to an earlier place.
        let mut from = order[place].1;
        while from < place {
            from = order[from].1;
        }
        order[place].1 = from;
        items.swap(place, from);
    }
}

fn sort(order: &mut [(f64, usize)]) {
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
}

#[cfg(test)]
mod tests {
    use super::sort_by_value;

    #[test]
    fn sorting_is_stable() {
        for seed in 0..200_usize {
            let length = seed % 23;
            let mut items: Vec<(f64, usize)> = (0..length)
                .map(|n| (((n * n + seed * 7) % 11) as f64 - 5.0, n))
                .collect();
            let mut expected = items.clone();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0));
            sort_by_value(&mut items, |item| item.0);
            assert_eq!(items, expected);
        }
    }
}
