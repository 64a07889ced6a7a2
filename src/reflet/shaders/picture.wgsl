#import layered
#import picture_entries

// Program: the picture, local light from maps.
