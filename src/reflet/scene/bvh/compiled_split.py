"""The tree's topology, compiled: binned surface area heuristic [Wald07], top down, without recursion."""

import numpy as np
from numba import njit

BINS = 16


@njit(cache=True)
def _half_area(box):
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x


@njit(cache=True)
def _empty(box):
    box[:3], box[3:] = np.inf, -np.inf


@njit(cache=True)
def _grow(box, other):
    for k in range(3):
        box[k] = min(box[k], other[k])
        box[3 + k] = max(box[3 + k], other[3 + k])


@njit(cache=True)
def _bin(value, low, scale):
    """The bin of a centroid; what is no number lies in the last."""
    at = (value - low) * scale
    return int(at) if 0.0 <= at < BINS else BINS - 1


@njit(cache=True)
def _levels_below(count, largest_leaf):
    """Inner nodes above the leaves of a subtree that is halved throughout."""
    levels = 0
    while count > largest_leaf:
        count = (count + 1) // 2
        levels += 1
    return levels


@njit(cache=True)
def _best_split(boxes, order, begin, end, centroids, bins, counts, behind):
    """(cost, axis, bin where the second half begins), the cost infinite where no plane parts the centroids."""
    best, best_axis, best_bin = np.inf, -1, 0
    box = np.empty(6)
    for axis in range(3):
        low, extent = centroids[axis], centroids[3 + axis] - centroids[axis]
        if not 0.0 < extent < np.inf:
            continue
        scale = BINS / extent
        counts[:] = 0
        for b in range(BINS):
            _empty(bins[b])
        for i in range(begin, end):
            t = order[i]
            b = _bin(0.5 * (boxes[t, axis] + boxes[t, 3 + axis]), low, scale)
            counts[b] += 1
            _grow(bins[b], boxes[t])
        _empty(box)
        count = 0
        for b in range(BINS - 1, 0, -1):
            _grow(box, bins[b])
            count += counts[b]
            behind[b] = _half_area(box) * count if count else np.inf
        _empty(box)
        count = 0
        for b in range(1, BINS):
            _grow(box, bins[b - 1])
            count += counts[b - 1]
            cost = _half_area(box) * count + behind[b] if count else np.inf
            if cost < best:
                best, best_axis, best_bin = cost, axis, b
    return best, best_axis, best_bin


@njit(cache=True)
def split(boxes, largest_leaf, most_depth):
    """``order`` and ``leaf_counts`` of a `Bvh` over the triangles' boxes (lower corner, upper corner), of float64.

    Where no plane parts the centroids, or a lopsided split would make the tree too deep, the triangles are halved as
    they come. O(n log n) with at most ``most_depth`` levels.
    """
    count = len(boxes)
    order = np.arange(count).astype(np.uint32)
    leaf_counts = np.empty(max(2 * count - 1, 0), np.uint8)
    bins, counts, behind = np.empty((BINS, 6)), np.empty(BINS, np.int64), np.empty(BINS)
    box, centroids = np.empty(6), np.empty(6)
    stack = np.empty((most_depth + 2, 3), np.int64)  # begin, end, depth
    nodes, top = 0, 0
    if count:
        stack[0] = 0, count, 0
        top = 1
    while top:
        top -= 1
        begin, end, depth = stack[top]
        size = end - begin
        middle = begin
        if size > 1:
            _empty(box)
            _empty(centroids)
            for i in range(begin, end):
                t = order[i]
                _grow(box, boxes[t])
                for k in range(3):
                    c = 0.5 * (boxes[t, k] + boxes[t, 3 + k])
                    centroids[k], centroids[3 + k] = min(centroids[k], c), max(centroids[3 + k], c)
            cost, axis, first_bin = _best_split(boxes, order, begin, end, centroids, bins, counts, behind)
            area = _half_area(box)
            fits = size <= largest_leaf
            if axis >= 0 and depth < most_depth and not (fits and area * size <= cost + area):
                low, scale = centroids[axis], BINS / (centroids[3 + axis] - centroids[axis])
                left, right = begin, end - 1
                while left <= right:
                    t = order[left]
                    if _bin(0.5 * (boxes[t, axis] + boxes[t, 3 + axis]), low, scale) < first_bin:
                        left += 1
                    else:
                        order[left], order[right] = order[right], t
                        right -= 1
                middle = left
                larger = max(middle - begin, end - middle)
                if depth + 1 + _levels_below(larger, largest_leaf) > most_depth:
                    middle = begin  # the order has changed, which does no harm
            if middle == begin and not fits:
                middle = (begin + end) // 2
        if middle == begin:
            leaf_counts[nodes] = size
        else:
            leaf_counts[nodes] = 0
            stack[top] = middle, end, depth + 1
            stack[top + 1] = begin, middle, depth + 1
            top += 2
        nodes += 1
    return order, leaf_counts[:nodes].copy()
