#import traced
#import picture_entries

// Program: the picture, local light from the mirrors' own meshes.
