within ;
package Loops "Components that feed through, for algebraic loops between them"
end Loops;
