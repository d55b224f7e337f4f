/// The three records nearest to the vertices that eye paths in the queue have just reached; NO_RECORD where there are fewer.
@group(1) @binding(15) var<storage, read_write> eye_records: array<vec4u>;
